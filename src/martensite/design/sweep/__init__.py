"""Sweeps of scenarios: variants, their runs, the store that holds them; offered in `martensite.design`."""
