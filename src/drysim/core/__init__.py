"""The numeric core: knows numbers only, and runs compiled or as plain Python."""
