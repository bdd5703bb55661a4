"""Figures of results: time series, hysteresis loops, measured records beside them."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
