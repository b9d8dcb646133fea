"""What the terminal shows: the result on stdout, all else on stderr. Writes no file."""
