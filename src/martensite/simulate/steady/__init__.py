"""Steady states, limit cycles and response curves: where a system ends under drives that stay as they are."""
