"""Bench: every approach, and programs that people know, by speed against error.

`questions` makes the job: one motion of each scene (`speed_error`), or the steady states of a
sweep (`steady`). The entries of the `shelf` and of the `peers` are made ready on a Work, timed
by the `clock`, and judged against a Yardstick (`judge`); a Panel holds their Scores. `hard`
puts every approach through the hard cases instead, each a Trial.
"""
