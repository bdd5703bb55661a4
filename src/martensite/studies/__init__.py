"""Studies: source papers rebuilt, one folder per paper, with printed and computed numbers compared."""

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)
