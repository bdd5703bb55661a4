"""Tuning rules for gains, and tests of a loop for them."""
