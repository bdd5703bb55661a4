"""Messages between page, server and workers: JSON, columns of numbers, and refusals in one sentence."""

from __future__ import annotations

import json
import math
import os
import sys
from array import array
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any, cast

from martensite.base.errors import InputError, MartensiteError, require_known
from martensite.scenario.exact_text import convert_to_plain
from martensite.scenario.examples import EXAMPLES

PACKAGE = Path(__file__).parents[1]
Request = Mapping[str, Any]
"""Request from outside; read its entries with `require_entry`."""
JsonTable = dict[str, Any]
"""A JSON table, or a table of a document."""
FOLDERS = sorted({str(path) for one in (EXAMPLES, PACKAGE) for path in (one, one.resolve())}, key=len, reverse=True)
"""Folders of the installation, removed from messages."""
MOST_BYTES = 8 * 2**20
"""Largest message that is read."""
DEEPEST_NESTING = 64
"""Largest depth of tables in tables."""


class Refusal(Exception):
    """An error for the page: a sentence, a status and a kind."""

    def __init__(self, sentence: str, status: int = 400, kind: str = "input") -> None:
        super().__init__(sentence)
        self.status = status
        """HTTP status."""
        self.kind = kind
        """input, failed, stopped, superseded, or lost."""


class BadMessageError(InputError):
    """A message does not fit its call."""


class WorkerJson(bytes):
    """JSON of a worker, passed on unchanged."""


def write_message(message: Any) -> bytes:
    """Return a message as one line of JSON; NaN and infinity become null."""
    try:
        text = json.dumps(message, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    except (TypeError, ValueError):
        text = json.dumps(convert_to_plain(message), ensure_ascii=False, separators=(",", ":"))
    return text.encode("utf-8", "replace")


class PackedColumns(bytes):
    """An answer with columns, packed by a worker (`pack_columns`)."""


COLUMNS_TYPE = "application/x-martensite-columns"
"""Media type of `PackedColumns`, for clients that accept it."""
NUMBERS = "$numbers"
SHORTEST_COLUMN = 16
"""Smallest length of a packed list."""
_NUMERIC = {float, int, type(None)}


def pack_columns(message: Any) -> PackedColumns:
    """Return a message with its long lists of numbers as binary.

    Four bytes, little endian, give the length of the following JSON, where such a list is `{"$numbers": [first,
    count]}`. Then all numbers follow as little-endian 64-bit floats in planes: the first byte of each number, then the
    second bytes, and so on, which compresses to half. Null becomes NaN.
    """
    numbers = array("d")

    def take_columns(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {name: take_columns(item) for name, item in cast("JsonTable", value).items()}
        if not isinstance(value, (list, tuple)):
            return value
        items = cast("list[Any]", value)
        if len(items) < SHORTEST_COLUMN or not set(map(type, items)) <= _NUMERIC:
            return [take_columns(item) for item in items]
        first = len(numbers)
        numbers.extend(math.nan if item is None else item for item in items)
        return {NUMBERS: [first, len(items)]}

    head = write_message(take_columns(message))
    if sys.byteorder == "big":
        numbers.byteswap()
    data = numbers.tobytes()
    return PackedColumns(len(head).to_bytes(4, "little") + head + b"".join(data[k::8] for k in range(8)))


def read_message(data: bytes) -> JsonTable:
    """Read a message from outside: a table of at most `MOST_BYTES` bytes."""
    if len(data) > MOST_BYTES:
        raise BadMessageError(f"The message has {len(data):,} bytes; at most {MOST_BYTES:,} do.")
    try:
        message = json.loads(
            data.decode("utf-8"), parse_constant=_replace_infinite, parse_float=_replace_infinite, parse_int=_is_whole
        )
        _check_depth(message)
        if b"\\u" in data:  # halves of characters, which no file can hold
            json.dumps(message, ensure_ascii=False).encode()
    except UnicodeError:
        raise BadMessageError("The message is not text in UTF-8.") from None
    except RecursionError:
        raise BadMessageError("The message is nested too deeply.") from None
    except ValueError as error:
        raise BadMessageError(f"The message is not JSON: {error}.") from None
    if not isinstance(message, dict):
        raise BadMessageError("The message must be a table (an object of JSON).")
    return cast("JsonTable", message)


def _replace_infinite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text[:20]} is no number that can be used")
    return value


def _is_whole(text: str) -> int:
    if len(text) > 300:  # no float holds it
        raise ValueError(f"a whole number has {len(text):,} digits")
    return int(text)


def _check_depth(message: Any) -> None:
    """Raise `RecursionError` if tables are nested too deeply."""
    level: list[Any] = [[message]]
    for _ in range(DEEPEST_NESTING + 1):
        items = (item for box in level for item in (box.values() if isinstance(box, dict) else box))
        level = [item for item in items if isinstance(item, (dict, list))]
        if not level:
            return
    raise RecursionError


def require_entry(request: Request, name: str, sort: type, default: Any = ...) -> Any:
    """Return a checked entry of a message."""
    if name not in request:
        if default is ...:
            raise BadMessageError(f"The message needs `{name}`; none given.")
        return default
    value = request[name]
    if sort is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if not isinstance(value, sort) or (sort is int and isinstance(value, bool)):
        raise BadMessageError(f"`{name}` must be {_WORDS[sort]}, but is {_shorten_value(value)}.")
    return value


def read_optional(request: Request, name: str, sort: type) -> Any:
    """Return a checked entry of a message; None if it is missing or null."""
    return None if request.get(name) is None else require_entry(request, name, sort)


def require_choice(request: Request, name: str, kind: str, valid: Collection[str]) -> str:
    """Return an entry of a message that is one of the valid names; `kind` is for the error."""
    value: str = require_entry(request, name, str)
    require_known(kind, value, valid)
    return value


def list_tables(request: Request, name: str) -> list[JsonTable]:
    """Return the tables in a list of a message; empty if it is missing."""
    return [require_table(entry, name) for entry in require_entry(request, name, list, [])]


def require_table(entry: Any, name: str) -> JsonTable:
    """Return an item of a list of a message, which must be a table."""
    if not isinstance(entry, dict):
        raise BadMessageError(f"`{name}` must hold tables, but holds {str(entry)[:40]!r}.")
    return cast("JsonTable", entry)


_WORDS: dict[type, str] = {
    str: "text",
    dict: "a table",
    list: "a list",
    float: "a number",
    int: "a whole number",
    bool: "true or false",
}


def _shorten_value(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}…"


def describe_refusal(error: BaseException) -> JsonTable:
    """Describe an error as a sentence, without folders of the installation, and its kind."""
    refusal = _describe_error(error)
    for folder in FOLDERS:
        refusal["refused"] = refusal["refused"].replace(f"{folder}{os.sep}", "")
    return refusal


def _describe_error(error: BaseException) -> JsonTable:
    if isinstance(error, MartensiteError):
        kind = "input" if isinstance(error, InputError) else "failed"
        return {"refused": str(error), "kind": kind}
    if isinstance(error, RecursionError):
        return {"refused": "The document is nested too deeply.", "kind": "input"}
    if isinstance(error, MemoryError):
        return {"refused": "There is not enough memory for this.", "kind": "failed"}
    if isinstance(error, OSError):
        reason = error.strerror or error
        return {"refused": f"A file could not be read or kept: {reason}.", "kind": "failed"}
    words = f"{type(error).__name__}: {error}"
    return {"refused": f"Unexpected error: {words}. Please report it.", "kind": "failed"}
