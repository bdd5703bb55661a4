"""Write TOML: documents with one section per table, and single values."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any, cast

_BARE = re.compile(r"^[A-Za-z0-9_-]+$")


def as_toml(document: Mapping[str, Any]) -> str:
    """Return a document as TOML: one section per table, nested tables inline."""
    lines = [f"{toml_key(k)} = {toml_value(v)}" for k, v in document.items() if not isinstance(v, dict)]
    for name, table in document.items():
        if isinstance(table, dict):
            entries = cast("dict[str, Any]", table)
            lines += ["", f"[{toml_key(name)}]"]
            lines += [f"{toml_key(k)} = {toml_value(v)}" for k, v in entries.items()]
    return "\n".join(lines).strip() + "\n"


def toml_value(value: Any) -> str:
    """Return a value as TOML, tables inline."""
    if isinstance(value, dict):
        table = cast("dict[str, Any]", value)
        return "{ " + ", ".join(f"{toml_key(k)} = {toml_value(v)}" for k, v in table.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(toml_value(item) for item in cast("list[Any]", value)) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return str(value).lower() if isinstance(value, bool) else str(value)


def toml_key(key: str) -> str:
    """Return a key as TOML, quoted if necessary."""
    return key if _BARE.match(key) else json.dumps(key, ensure_ascii=False)
