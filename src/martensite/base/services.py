"""Functions of higher packages that methods of lower packages offer: figures, pages, files, widgets.

Lower packages name no module of a higher package. The root package registers the functions with `offer_services`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

_HOMES: dict[str, str] = {}


def offer_services(homes: Mapping[str, str]) -> None:
    """Register the place, `module:function`, of each service by name."""
    _HOMES.update(homes)


def import_service(name: str) -> Callable[..., Any]:
    """Return the function or class that is registered under a name."""
    module, _, function = _HOMES[name].partition(":")
    return getattr(import_module(module), function)
