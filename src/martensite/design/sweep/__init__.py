"""Sweeps of scenarios: variants, runs and stores."""
