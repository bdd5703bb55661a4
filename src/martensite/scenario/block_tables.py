"""Blocks of models as plain tables, and back: kind, and every declared value."""

from __future__ import annotations

import math
from typing import Any, cast

from martensite.base.errors import InputError
from martensite.identify.blocks.base import BLOCKS, AbstractBlock

NUMBERS = {"inf": math.inf, "-inf": -math.inf}
"""Numbers that JSON has no words for."""


def block_table(block: AbstractBlock) -> dict[str, Any]:
    """A block as a table of plain values; blocks inside it are tables of their own.

    Raises:
        InputError: the block is not registered, or has a value that no file can hold.
    """
    if not block.registered_name:
        raise InputError(
            f"Block `{type(block).__name__}` has no registered name and cannot be written; file "
            "its class with `@BLOCKS.register`."
        )
    values = {
        name: _require_plain(getattr(block, name), f"`{name}` of block `{block.registered_name}`")
        for name in block.declarations
    }
    return {"kind": block.registered_name, "parameters": values}


def block_of(table: dict[str, Any]) -> AbstractBlock:
    """The block of a table.

    Raises:
        InputError: no block of its kind is registered, or a value is out of range.
        KeyError, TypeError, ValueError: it is no such table.
    """
    kind, given = str(table["kind"]), dict(table["parameters"])
    return BLOCKS[kind](**{name: _read_value(value) for name, value in given.items()})


def _require_plain(value: Any, what: str) -> Any:
    if isinstance(value, AbstractBlock):
        return block_table(value)
    if isinstance(value, tuple | list):
        return [_require_plain(one, what) for one in cast("list[Any]", value)]
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else {"number": str(float(value))}
    raise InputError(f"The value of {what} is a {type(value).__name__}, which no file can hold.")


def _read_value(value: Any) -> Any:
    if isinstance(value, list):
        return tuple(_read_value(one) for one in cast("list[Any]", value))
    if isinstance(value, dict):
        table = cast("dict[str, Any]", value)
        return NUMBERS[table["number"]] if "number" in table else block_of(table)
    return value
