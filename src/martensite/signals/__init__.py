"""Signals: waveforms and records as functions of time."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
