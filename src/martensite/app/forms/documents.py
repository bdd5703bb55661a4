"""Entries of a TOML document by dotted path: looked up, replaced, taken away."""

from __future__ import annotations

from typing import Any, cast

from martensite.app.messages import JsonTable, Request


def find_entry(document: Request, path: str) -> Any:
    """Return the value at a path, or None."""
    node: Any = document
    for key in path.split("."):
        if not isinstance(node, dict) or key not in node:
            return None
        node = cast("JsonTable", node)[key]
    return node


def find_table(document: Request, path: str) -> JsonTable:
    """Return the table at a path; a bare text is its kind, and nothing an empty one."""
    found = find_entry(document, path)
    if isinstance(found, str):
        return {"kind": found}
    return cast("JsonTable", found) if isinstance(found, dict) else {}


def put_entry(document: JsonTable, path: str, value: Any) -> None:
    """Put a value at a path; tables on the way are made, bare kinds become tables."""
    *above, last = path.split(".")
    node = document
    for key in above:
        below = node.get(key)
        if not isinstance(below, dict):
            below = {"kind": below} if isinstance(below, str) else {}
            node[key] = below
        node = cast("JsonTable", below)
    node[last] = value


def remove_entry(document: JsonTable, path: str) -> None:
    """Take an entry away, and the tables above it that are empty then."""
    head, _, last = path.rpartition(".")
    owner = find_entry(document, head) if head else document
    if not isinstance(owner, dict) or last not in owner:
        return
    del cast("JsonTable", owner)[last]
    if head and not owner and "." in head:
        remove_entry(document, head)
