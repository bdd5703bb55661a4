"""Changes to a scenario from outside: `element.diameter = "0.25 mm"`, before it is built.

A changed scenario is written out as TOML again, so that saved results hold the scenario
that was run and not the one it was made from.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any, cast

from martensite.base import units
from martensite.base.errors import ParameterError

_BARE = re.compile(r"^[A-Za-z0-9_-]+$")


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
    """A copy of a TOML document with the values at the given dotted paths replaced."""
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


def as_toml(document: Mapping[str, Any]) -> str:
    """Write a document as TOML: one section per table, tables below it inline."""
    lines = [f"{toml_key(k)} = {toml_value(v)}" for k, v in document.items() if not isinstance(v, dict)]
    for name, table in document.items():
        if isinstance(table, dict):
            entries = cast("dict[str, Any]", table)
            lines += ["", f"[{toml_key(name)}]"]
            lines += [f"{toml_key(k)} = {toml_value(v)}" for k, v in entries.items()]
    return "\n".join(lines).strip() + "\n"


def toml_value(value: Any) -> str:
    """A value as TOML, tables inline."""
    if isinstance(value, dict):
        table = cast("dict[str, Any]", value)
        return "{ " + ", ".join(f"{toml_key(k)} = {toml_value(v)}" for k, v in table.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(toml_value(item) for item in cast("list[Any]", value)) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return str(value).lower() if isinstance(value, bool) else str(value)


def toml_key(key: str) -> str:
    """A key as TOML, in quotes where it needs them."""
    return key if _BARE.match(key) else json.dumps(key, ensure_ascii=False)
