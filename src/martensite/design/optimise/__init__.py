"""Designs of least cost under constraints, found by derivatives through the march."""
