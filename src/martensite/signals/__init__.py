"""Signals: what drives a system, as a function of time (and, for controllers, measurements)."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
