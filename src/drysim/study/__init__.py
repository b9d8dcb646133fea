"""What is asked of drysim: cases in, outcomes out. Writes no file and shows nothing.

`case.prepare` crosses a scenario to a Case, and `run.solve` gives its Outcome. Many seeds of a
case are an Ensemble (`ensembles`), many cases a Table (`sweeps`), and what several approaches
or laws make of them a Comparison (`comparisons`). `bench` times and judges approaches;
`cluster` lends a sweep other machines.
"""
