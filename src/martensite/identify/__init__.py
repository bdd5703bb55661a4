"""Identification: dynamic models of blocks from records."""
