"""Mechanics that several mechanisms share; none is registered here."""
