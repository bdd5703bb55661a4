"""Summaries of each kind of result: one file per kind, one `Summary` for all pages."""
