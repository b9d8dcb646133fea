"""Dynamic laws: friction with a rate or a state of its own, by Taylor series."""
