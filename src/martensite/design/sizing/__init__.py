"""Sizing: from force, stroke and rate to wires, currents and times, with the simulated wire."""
