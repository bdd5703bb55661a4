"""Entries of a TOML document by dotted path."""

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
    """Return the table at a path; a text is its kind, a missing one is empty."""
    entry = find_entry(document, path)
    if isinstance(entry, str):
        return {"kind": entry}
    return cast("JsonTable", entry) if isinstance(entry, dict) else {}


def put_entry(document: JsonTable, path: str, value: Any) -> None:
    """Set a value at a path; tables on the way are created, texts become tables of a kind."""
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
    """Remove an entry, and the tables above it that become empty."""
    head, _, last = path.rpartition(".")
    owner = find_entry(document, head) if head else document
    if not isinstance(owner, dict) or last not in owner:
        return
    del cast("JsonTable", owner)[last]
    if head and not owner and "." in head:
        remove_entry(document, head)
