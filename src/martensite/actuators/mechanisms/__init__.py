"""Mechanisms, which the elements pull."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
