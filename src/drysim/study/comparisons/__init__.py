"""Comparisons: one base motion under several approaches and laws, and a verdict on each."""
