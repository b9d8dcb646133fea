"""Ensembles: one scenario under many seeds, and what they have in common."""
