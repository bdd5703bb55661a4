"""Measured files: one reader for all of them, the meaning of their columns, and published data sets."""
