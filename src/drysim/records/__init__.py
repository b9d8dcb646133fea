"""Measured records: base motion and normal force from files.

`options` contains the blocks of a scenario; without a record only this module is imported.
`record` reads a file into samples in SI. It uses `columns` (bytes, columns, units), `formats`
and `text` (file formats), `clean` (even grid, resampling, filters) and `warnings`.
"""

SI = {"acceleration": "m/s²", "velocity": "m/s", "displacement": "m", "force": "N"}
"""SI unit by measured quantity."""
