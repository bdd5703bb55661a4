"""Regulators on linear plants; gains scheduled over the stroke; an inverse of hysteresis."""
