"""Heat loss of an element to the ambient."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
