"""Sweeps: many variants of a scenario, in chunks that survive whatever happens to the rest."""
