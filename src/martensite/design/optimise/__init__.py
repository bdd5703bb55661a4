"""Optimisation of designs under constraints, with exact derivatives."""
