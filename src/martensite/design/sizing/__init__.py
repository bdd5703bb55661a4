"""Sizing of wires from force, stroke and rate, with simulated cycles."""
