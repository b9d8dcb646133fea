"""Numbers only: closed-form physics that may be compiled. Knows no file, no unit, no terminal."""
