"""Sweeps of scenarios: variants, their runs, and the store that holds them."""
