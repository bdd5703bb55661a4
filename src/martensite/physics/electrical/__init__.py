"""Electrical side: resistance of the element, and what drives it. One file per model."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
