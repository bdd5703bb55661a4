"""Electrical side: resistance of the element, and what drives it. One file per model."""
