"""Changes to the text of a scenario before it is built, such as `element.diameter = "0.25 mm"`.

A changed scenario is written as TOML again, so that saved results hold the scenario of the run.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any, cast

from martensite.base import units
from martensite.base.errors import ParameterError


def read_settings(settings: Sequence[str]) -> dict[str, Any]:
    """Return the values of `path=value` texts; a value that is not TOML is text.

    Raises:
        ParameterError: a text has no equals sign.
    """
    values: dict[str, Any] = {}
    for setting in settings:
        path, equals, value = setting.partition("=")
        if not equals or not path.strip():
            raise ParameterError(
                f'`{setting}` is not a setting; write `path=value`, for example `element.diameter="0.25 mm"`.'
            )
        values[path.strip()] = _parse_value(value.strip())
    return values


def _parse_value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def change_document(document: Mapping[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of a TOML document with new values at dotted paths."""
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
            raise ParameterError(f"`{path}` cannot be set: `{'.'.join(above[:depth])}` is a value, not a table.")
        node = cast("dict[str, Any]", below)
    node[last] = value
