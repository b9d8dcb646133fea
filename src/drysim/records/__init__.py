"""Measured records: base motion and normal force from files.

`options` is what a scenario may say of a record, `record` goes by it from the file to samples
in SI: `columns` holds its bytes, in which `formats` and `text` find columns, and chooses one
and its unit, `clean` puts it onto an even grid and removes what is asked for, `warnings` says
what a reader should know. A scenario without a record executes `options` alone.
"""

SI = {"acceleration": "m/s²", "velocity": "m/s", "displacement": "m", "force": "N"}
"""The unit of ü, u̇ and u, and of a normal force."""
