"""Stops: the end of the stroke, by bumpers or by rigid impacts."""
