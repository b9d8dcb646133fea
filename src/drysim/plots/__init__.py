"""Pictures; each function takes a result and returns a figure of matplotlib."""
