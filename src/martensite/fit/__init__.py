"""Fits of the numbers of a scenario to logs: search, uncertainty, and what the data leave open."""
