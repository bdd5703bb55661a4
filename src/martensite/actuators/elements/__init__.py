"""Elements: a law, a heat balance, a resistance and a geometry, coupled by numbers."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
