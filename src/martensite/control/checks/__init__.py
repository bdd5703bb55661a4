"""Checks of a guard."""
