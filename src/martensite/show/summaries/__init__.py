"""Summaries of results, one file per kind of result."""
