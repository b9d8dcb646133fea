"""Sweeps: a grid or a sample of cases, block by block, and the table it comes to.

A Plan cuts the cases into Pieces, each known by its number alone. A piece is solved into a
Batch, which is columns of numbers: by one call of the kernel (`orbits`), or case by case
(`cases`; of many seeds `over_seeds`). A Store keeps batches on the disk, packed as they travel;
`gathering` counts them into a Tally for each approach as they pass. The Table makes its Rows
from them again when somebody asks.
"""
