"""Changes to a scenario from outside: `element.diameter = "0.25 mm"`, before it is built.

A changed scenario is written out as TOML again, so that saved results hold the scenario
that was run and not the one it was made from.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any, cast

from martensite.base import units
from martensite.base.errors import ParameterError


def read_settings(settings: Sequence[str]) -> dict[str, Any]:
    """Read `path=value` texts; a value that is not TOML is text, so quotes may be left out.

    Raises:
        ParameterError: a text has no equals sign.
    """
    found: dict[str, Any] = {}
    for setting in settings:
        path, equals, value = setting.partition("=")
        if not equals or not path.strip():
            raise ParameterError(
                f'`{setting}` is not a setting; write `path=value`, for example `element.diameter="0.25 mm"`.'
            )
        found[path.strip()] = _parse_value(value.strip())
    return found


def _parse_value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def change_document(document: Mapping[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of a TOML document with the values at the given dotted paths replaced."""
    copy = deepcopy(dict(document))
    for path, value in settings.items():
        _set_value(copy, path, units.write_pint(value) if units.is_quantity(value) else deepcopy(value))
    return copy


def _set_value(document: dict[str, Any], path: str, value: Any) -> None:
    *above, last = path.split(".")
    node = document
    for depth, key in enumerate(above, start=1):
        below = node.setdefault(key, {})
        if isinstance(below, str) and depth > 1:
            below = node[key] = {"kind": below}
        if not isinstance(below, dict):
            held = ".".join(above[:depth])
            raise ParameterError(f"`{path}` cannot be set: `{held}` is a value, not a table.")
        node = cast("dict[str, Any]", below)
    node[last] = value
