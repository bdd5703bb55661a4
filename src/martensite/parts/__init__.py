"""Names for the parts of a user: interfaces, registries, declared parameters."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
