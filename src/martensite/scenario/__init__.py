"""Scenarios and other files: measured tables and data sets, results as netCDF, citations."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
