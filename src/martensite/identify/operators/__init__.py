"""Operators of several blocks: plays, sections, curves."""
