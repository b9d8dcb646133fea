"""Bench: every approach, and programs that people know, by speed against error."""
