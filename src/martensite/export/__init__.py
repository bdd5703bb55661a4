"""Exports of martensite models to other programs, offered as `martensite.export`."""

import sys

from martensite.base.lazy import attach_names

__getattr__, __dir__ = attach_names(__name__)

if "gymnasium" in sys.modules:
    from martensite.export.gymnasium_names import register_environments

    register_environments()
