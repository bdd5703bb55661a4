"""Ways out: martensite elements in the programs of others, offered as `martensite.export`."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
