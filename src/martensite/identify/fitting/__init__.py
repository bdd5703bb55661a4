"""Fits of parameters to measured records: search, uncertainty, and what the data leave open."""
