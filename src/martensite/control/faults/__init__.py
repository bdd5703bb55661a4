"""Faults: what goes wrong on a bench, and when."""
