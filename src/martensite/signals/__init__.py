"""Signals: what drives a system, as a function of time (and, for controllers, measurements)."""
