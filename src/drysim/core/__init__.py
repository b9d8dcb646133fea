"""Numbers only: closed-form physics that may be compiled. Knows no file and no terminal."""
