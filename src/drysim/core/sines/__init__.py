"""Sines: one scene whose base moves by sines, from event to event, and its periodic orbits."""
