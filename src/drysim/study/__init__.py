"""Studies: what is computed from a scenario, one case or many, and what results.

From the bottom up: `statistics` holds rows and columns of results, `case` is a scenario ready
to be solved, `budget` what it costs, `preparation` the way to it. `outcome`, `table` and
`warnings` describe results. `run` solves one case. `plan` divides a sweep, or the seeds of an
ensemble, into ranges, `store` saves them, `cluster` distributes them, `sweep` and `ensemble`
collect them. `compare` compares approaches. `doctor` checks the installation, and `gallery`
holds the shipped scenarios.
"""
