"""Sizing, sweeps, sensitivity and optimisation of designs."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
