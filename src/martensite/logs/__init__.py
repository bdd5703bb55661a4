"""Measured files: one reader, the meaning of columns, and published data sets."""
