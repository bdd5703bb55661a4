"""Regulators on linear plants; an inverse of hysteresis."""
