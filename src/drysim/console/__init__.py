"""Terminal output: results on stdout, everything else on stderr. Writes no file."""
