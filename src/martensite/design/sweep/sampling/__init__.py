"""How the space of a sweep is filled: on a grid, or by samples."""
