"""Supervisors: who has the last word on a bench. One file per kind."""
