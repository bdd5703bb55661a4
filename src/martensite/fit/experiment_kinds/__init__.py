"""Kinds of experiment in logs: one file each, found by its folder."""
