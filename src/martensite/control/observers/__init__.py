"""Observers: what estimates that which no sensor sees."""
