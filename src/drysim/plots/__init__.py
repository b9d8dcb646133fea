"""PNG pictures; each function takes a result and the output folder."""
