"""What parts of one's own are written with: interfaces, registries, declared numbers."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
