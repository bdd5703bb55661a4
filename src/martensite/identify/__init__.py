"""Identification: parameters of laws and models of blocks from logs, and what logs leave open."""
