"""Operators that several blocks share: plays, sections, curves."""
