"""Fluids around the element."""
