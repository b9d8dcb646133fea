"""What is done with a scenario, one case or many, and what comes of it.

From the bottom up: `rows` and `statistics` hold numbers, `case` is a scenario ready to be
solved, `outcome`, `table` and `warnings` say what came out. `run` solves one case, `ensemble`
its seeds; `plan` cuts a sweep into blocks, `store` keeps them, `cluster` has them solved
elsewhere, `sweep` gathers them, and `compare` holds approaches against each other. Beside these
stand `doctor` and `gallery`.
"""
