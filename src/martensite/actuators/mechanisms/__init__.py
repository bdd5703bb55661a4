"""Mechanisms: what the element pulls on. One file each."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
