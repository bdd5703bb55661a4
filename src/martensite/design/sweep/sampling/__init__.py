"""Sampling of the space of a sweep: on a grid, or at random."""
