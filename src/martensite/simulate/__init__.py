"""Transient simulation with its result and status."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
