"""Sensors: what is measured of what is true."""
