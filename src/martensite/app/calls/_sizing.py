"""What the calls about sizing share: the fields of a request, typed, read and refused."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from martensite.app.messages import BadMessageError, wanted
from martensite.base import units
from martensite.base.errors import InputError, ParameterError, suggest_name
from martensite.base.parameters import REQUIRED, Declared
from martensite.design.sizing.request import WireRequest
from martensite.scenario.catalogue import describe_class

EXAMPLE = {"force": "8 N", "stroke": "5 mm", "rate": "0.05 Hz", "supply": "12 V"}
"""A request that some wires meet."""
LONGEST = 200


def fields() -> list[dict[str, Any]]:
    """Every field of a request: what is declared of it, its default as text, an example."""
    found: list[dict[str, Any]] = []
    for entry in describe_class("", WireRequest)["parameters"]:
        declared = WireRequest.declarations[entry["name"]]
        found.append(
            entry
            | {
                "default": _default(declared),
                "choices": list(declared.choices),
                "example": EXAMPLE.get(entry["name"], ""),
            }
        )
    return found


def _default(declared: Declared) -> str:
    """The default as one would type it; `none` for a limit that is none."""
    if declared.default is REQUIRED:
        return ""
    if declared.kind != "parameter":
        return str(declared.default)
    if math.isinf(declared.default):
        return "none"
    unit = units.choose_readable_unit(declared.unit)
    number = f"{units.from_si(declared.default, unit, declared.unit):.6g}"
    return number if unit == "1" else f"{number} {unit}"


def typed(request: Mapping[str, Any]) -> dict[str, str]:
    """The fields of a message that are filled in.

    Raises:
        BadMessageError: one is not text, too long, or not known.
    """
    given = wanted(request, "fields", dict, {})
    for name in given:
        if name not in WireRequest.declarations:
            nearest = suggest_name(str(name), WireRequest.declarations)
            raise BadMessageError(f"A sizing has no field `{str(name)[:60]}`. {nearest}")
        if len(wanted(given, name, str)) > LONGEST:
            raise BadMessageError(f"Field `{name}` has more than {LONGEST} letters.")
    return {name: text.strip() for name, text in given.items() if text.strip()}


def value(name: str, text: str) -> Any:
    """What is typed into a field, in SI and within its range.

    Raises:
        InputError: it cannot be read, or is out of range.
    """
    declared = WireRequest.declarations[name]
    if declared.kind == "parameter":
        units.parse_quantity(
            text, declared.unit
        )  # its sentences stand beside the field and need no owner
    return declared.convert("the sizing", name, text)


def read(given: Mapping[str, str]) -> tuple[dict[str, Any], dict[str, str]]:
    """Values of the fields that can be read, and the sentences about the others."""
    found: dict[str, Any] = {}
    refused: dict[str, str] = {}
    for name, text in given.items():
        try:
            found[name] = value(name, text)
        except InputError as error:
            refused[name] = str(error)
    return found, refused


def asked(request: Mapping[str, Any]) -> WireRequest:
    """The request of a message.

    Raises:
        InputError: a field is missing or wrong, or the fields contradict each other.
    """
    given = typed(request)
    needed = [n for n, d in WireRequest.declarations.items() if d.default is REQUIRED]
    absent = [f"`{name}`" for name in needed if name not in given]
    if absent:
        raise ParameterError(f"Fill in {', '.join(absent)} first.")
    found, refused = read(given)
    if refused:
        raise ParameterError(" ".join(refused.values()))
    return WireRequest(**found)
