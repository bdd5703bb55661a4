"""Figures of results: time series, hysteresis loops, comparisons with measured records."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
