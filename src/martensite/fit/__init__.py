"""Fits of scenario parameters to logs: search, uncertainty, and identifiability."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
