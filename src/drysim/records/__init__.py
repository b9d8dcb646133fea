"""Measured records: base motion and normal force from files."""
