"""The page's TypeScript types, read from their files, and whether an answer is of such a type.

Only what those files use is understood: interfaces, unions, tuples, lists, records, literals. Of a
type that is `unknown` every value is.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

from martensite.app.messages import write_message

SOURCES = Path(__file__).parents[1] / "web" / "src"
_TOKEN = re.compile(r"\s+|/\*\*.*?\*/|//[^\n]*|(\"[^\"]*\"|[A-Za-z_]\w*|.)", re.DOTALL)
Fields = dict[str, tuple[bool, Any]]
"""By name: whether it may be left out, and its type."""


class Reader:
    """Reads the declarations of one file."""

    def __init__(self, text: str) -> None:
        self.tokens = [m[1] for m in _TOKEN.finditer(text) if m[1]]
        self.types: dict[str, Any] = {}
        while self.tokens:
            word = self.take()
            if word == "interface":
                name, bases = self.take(), list[Any]()
                while self.tokens[0] in ("extends", ","):
                    bases.append(("name", (self.take(), self.take())[1]))
                self.types[name] = ("object", bases, self.fields())
            elif word == "type":
                name = self.take()
                self.take("=")
                self.types[name] = self.union()

    def take(self, wanted: str = "") -> str:
        found = self.tokens.pop(0)
        assert wanted in ("", found), f"{found!r} stands where {wanted!r} is expected"
        return found

    def fields(self) -> Fields:
        self.take("{")
        found: Fields = {}
        while (name := self.take()) != "}":
            if name in ";,":
                continue
            optional = self.tokens[0] == "?" and bool(self.take())
            self.take(":")
            found[name] = optional, self.union()
        return found

    def union(self) -> Any:
        parts = []
        while True:
            if self.tokens[0] == "|":
                self.take()
            parts.append(self.listed())
            while self.tokens[0] == "&":
                self.take()
                parts[-1] = ("object", [parts[-1]], self.fields())
            if self.tokens[0] != "|":
                return ("union", parts)

    def listed(self) -> Any:
        return self.enclose(self.single())

    def enclose(self, found: Any) -> Any:
        if self.tokens[:2] != ["[", "]"]:
            return found
        del self.tokens[:2]
        return self.enclose(("list", found))

    def single(self) -> Any:
        if self.tokens[0] == "{":
            return ("object", [], self.fields())
        word = self.take()
        if word == "(":
            found = self.union()
            self.take(")")
            return found
        if word == "[":
            return ("tuple", list(self.items()))
        if word == "Record":
            self.take("<")
            self.union()
            self.take(",")
            found = ("record", self.union())
            self.take(">")
            return found
        return ("literal", word[1:-1]) if word[0] == '"' else ("name", word)

    def items(self) -> Iterator[Any]:
        while self.tokens[0] != "]":
            if self.tokens[1] == ":":
                del self.tokens[:2]
            yield self.union()
            if self.tokens[0] == ",":
                self.take()
        self.take("]")


@cache
def types_of(page: str) -> dict[str, Any]:
    """The types of a page, by name."""
    return Reader((SOURCES / page / "types.ts").read_text("utf-8")).types


PLAIN: dict[str, Callable[[Any], bool]] = {
    "string": lambda one: isinstance(one, str),
    "number": lambda one: isinstance(one, int | float) and not isinstance(one, bool),
    "boolean": lambda one: isinstance(one, bool),
    "null": lambda one: one is None,
    "unknown": lambda one: True,
}


def fields_of(kind: Any, types: dict[str, Any]) -> Fields:
    """All fields of an interface, those of what it extends included."""
    if kind[0] == "name":
        kind = types[kind[1]]
    _, bases, own = kind
    inherited: Fields = {}
    for base in bases:
        inherited |= fields_of(base, types)
    return inherited | own


def faults(value: Any, kind: Any, types: dict[str, Any], path: str) -> list[str]:
    """Where a value is not of a type."""
    sort, about, *_ = kind
    if sort == "name":
        if about in PLAIN:
            return [] if PLAIN[about](value) else [f"{path} is {value!r:.60}, no {about}"]
        return faults(value, types[about], types, path)
    if sort == "union":
        tried = [faults(value, one, types, path) for one in about]
        return min(tried, key=len)
    if sort == "literal":
        return [] if value == about else [f"{path} is {value!r:.60}, not {about!r}"]
    if sort in ("list", "tuple"):
        if not isinstance(value, list) or (sort == "tuple" and len(value) != len(about)):
            return [f"{path} is {value!r:.60}, no {sort}"]
        kinds = about if sort == "tuple" else [about] * len(value)
        pairs = enumerate(zip(value, kinds, strict=True))
        return [f for k, (one, own) in pairs for f in faults(one, own, types, f"{path}.{k}")]
    if not isinstance(value, dict):
        return [f"{path} is {value!r:.60}, no table"]
    if sort == "record":
        return [f for k, one in value.items() for f in faults(one, about, types, f"{path}.{k}")]
    known = fields_of(kind, types)
    found: list[str] = []  # an answer may hold more than the page reads
    for name, (optional, own) in known.items():
        if name in value:
            found += faults(value[name], own, types, f"{path}.{name}")
        elif not optional:
            found.append(f"{path}.{name} is missing")
    return found


def check_answer(answer: Any, page: str, name: str) -> None:
    """Fail unless an answer, as it goes out, is of a type of a page."""
    types = types_of(page)
    found = faults(json.loads(write_message(answer)), ("name", name), types, name)
    assert not found, "; ".join(found[:8])
