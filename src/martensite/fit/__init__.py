"""Fits of the numbers of a scenario to logs: search, uncertainty, and what the data leave open."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
