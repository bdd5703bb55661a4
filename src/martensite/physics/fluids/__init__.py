"""Fluids around the element: one file per fluid."""
