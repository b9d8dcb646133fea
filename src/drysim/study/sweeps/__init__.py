"""Sweeps: a grid or a sample of cases, block by block, and the table it comes to."""
