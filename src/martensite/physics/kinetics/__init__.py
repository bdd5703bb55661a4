"""Transformation kinetics that several laws share; no law is registered here."""
