"""Regulators of linear plants, gain schedules, and inverse hysteresis."""
