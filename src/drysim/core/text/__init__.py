"""Text: doubles as the shortest decimals that read back the same, and rows of CSV of them."""
