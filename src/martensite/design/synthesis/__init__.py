"""Linear plants at operating points."""
