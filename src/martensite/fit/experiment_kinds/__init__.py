"""Kinds of experiment that logs can hold: one file each, found by its folder."""
