"""Supervisors: who has the last word on a bench."""
