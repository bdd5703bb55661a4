"""Functions of higher packages that methods of lower ones offer: figures, pages, files, widgets.

A lower package names no module of a higher one. The root package enters the home of each function with
`offer_services`; `import_service` imports it when it is first used.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

_HOMES: dict[str, str] = {}


def offer_services(homes: Mapping[str, str]) -> None:
    """Enter the home, `module:function`, of each service by its name."""
    _HOMES.update(homes)


def import_service(name: str) -> Callable[..., Any]:
    """Return the function, or the class, that the root package has entered under a name."""
    module, _, function = _HOMES[name].partition(":")
    return getattr(import_module(module), function)
