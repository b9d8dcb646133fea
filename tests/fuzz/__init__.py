"""Damaged and hostile input in numbers: `python -m fuzz` from tests/ repeats a campaign."""
