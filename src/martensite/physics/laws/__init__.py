"""Stress–strain–temperature laws; no law imports another."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
