"""Tuning of gains by rules and by search."""
