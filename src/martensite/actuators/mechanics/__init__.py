"""Mechanics that several mechanisms share; no mechanism is registered here."""
