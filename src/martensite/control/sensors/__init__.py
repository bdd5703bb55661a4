"""Sensors: readings of the true signals of a plant."""
