"""Linear plants and what is designed on them; an inverse of hysteresis."""
