"""Sweeps of scenarios: from a file to a plan, and to a Zarr store that holds everything."""
