"""Controllers compute the signal of a drive from a reference and readings."""
