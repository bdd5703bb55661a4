"""Boards: firmware around an exported loop, its link, logs and experiments."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
