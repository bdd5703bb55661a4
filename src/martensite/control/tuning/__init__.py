"""Tuning: gains of controllers from rules and by search."""
