"""Heat loss of an element to its surroundings: one file per model."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
