"""Periodic orbits of a scene: return maps, search from a start, continuation, exponents."""
