"""Studies: every source paper rebuilt, one folder per paper, with its printed numbers beside the computed ones."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
