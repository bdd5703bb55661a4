"""Calls about sizing: the form, the search, the maker's table."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from martensite.app.calls.size_loop import format_loop
from martensite.app.messages import BadMessageError, JsonTable, Request, require_entry
from martensite.app.worker import Desk
from martensite.base import units
from martensite.base.errors import InputError, ParameterError, suggest_name
from martensite.base.parameters import REQUIRED, FieldDeclaration
from martensite.design.sizing.candidates import Candidate, list_sizes, size_wire
from martensite.design.sizing.catalogue_check import AMBIENT, STRESS, check_catalogue
from martensite.design.sizing.remarks import Margin, find_tightest, list_margins
from martensite.design.sizing.request import ALLOYS, WireRequest
from martensite.design.sizing.scenario import format_scenario
from martensite.physics.materials.wires import WireCatalogue, load_wires
from martensite.scenario.catalogue import describe_class
from martensite.show.summaries import sizing as words

EXAMPLE = {"force": "8 N", "stroke": "5 mm", "rate": "0.05 Hz", "supply": "12 V"}
"""A feasible request."""
LONGEST_FIELD = 200


def list_fields() -> list[JsonTable]:
    """Return each field of a request with declaration, default and example."""
    entries: list[JsonTable] = []
    for entry in describe_class("", WireRequest)["parameters"]:
        declared = WireRequest.declarations[entry["name"]]
        entries.append(
            entry
            | {
                "default": _write_default(declared),
                "choices": list(declared.choices),
                "example": EXAMPLE.get(entry["name"], ""),
            }
        )
    return entries


def _write_default(declared: FieldDeclaration) -> str:
    if declared.default is REQUIRED:
        return ""
    if declared.kind != "parameter":
        return str(declared.default)
    if math.isinf(declared.default):
        return "none"
    unit = units.choose_readable_unit(declared.unit)
    number = f"{units.from_si(declared.default, unit, declared.unit):.6g}"
    return number if unit == "1" else f"{number} {unit}"


def read_fields(request: Request) -> dict[str, str]:
    """Return the filled-in fields of a message."""
    given = require_entry(request, "fields", dict, {})
    for name in given:
        if name not in WireRequest.declarations:
            nearest = suggest_name(str(name), WireRequest.declarations)
            raise BadMessageError(f"A sizing has no field `{str(name)[:60]}`. {nearest}")
        if len(require_entry(given, name, str)) > LONGEST_FIELD:
            raise BadMessageError(f"Field `{name}` has more than {LONGEST_FIELD} letters.")
    return {name: text.strip() for name, text in given.items() if text.strip()}


def convert_field(name: str, text: str) -> Any:
    """Return the text of a field in SI, checked."""
    declared = WireRequest.declarations[name]
    if declared.kind == "parameter":
        units.parse_quantity(text, declared.unit)  # the page shows these sentences next to the field
    return declared.convert("the sizing", name, text)


def convert_fields(given: Mapping[str, str]) -> tuple[JsonTable, dict[str, str]]:
    """Return the values of valid fields, and the errors of the others."""
    table: JsonTable = {}
    refused: dict[str, str] = {}
    for name, text in given.items():
        try:
            table[name] = convert_field(name, text)
        except InputError as error:
            refused[name] = str(error)
    return table, refused


def read_request(request: Request) -> WireRequest:
    """Return the request of a message."""
    given = read_fields(request)
    needed = [n for n, d in WireRequest.declarations.items() if d.default is REQUIRED]
    absent = [f"`{name}`" for name in needed if name not in given]
    if absent:
        raise ParameterError(f"Fill in {', '.join(absent)} first.")
    fields, refused = convert_fields(given)
    if refused:
        raise ParameterError(" ".join(refused.values()))
    return WireRequest(**fields)


def describe_sizing(request: Request, desk: Desk) -> JsonTable:
    """Return the form of a sizing: its fields and their errors.

    {"fields": {"force": "8 N", …}} -> {"fields": [declared…], "refused": {name: sentence}, "contradiction": sentence or
    "", "example": {…}}

    Unknown fields, as of an old link, are listed in "unknown" and ignored.
    """
    given = require_entry(request, "fields", dict, {})
    requirements = {name: text for name, text in given.items() if name in WireRequest.declarations}
    fields, refused = convert_fields(read_fields({"fields": requirements}))
    return {
        "fields": list_fields(),
        "unknown": [str(name)[:60] for name in given if name not in requirements],
        "refused": refused,
        "contradiction": "" if refused else _find_contradiction(fields),
        "example": EXAMPLE,
    }


def _find_contradiction(fields: Request) -> str:
    """Return the contradiction between valid fields, empty without one."""
    needed = [n for n, d in WireRequest.declarations.items() if d.default is REQUIRED]
    values: JsonTable = {**dict.fromkeys(needed, 1.0), **fields}
    try:
        WireRequest(**values)
    except InputError as error:
        return str(error)
    return ""


def size_wires(request: Request, desk: Desk) -> JsonTable:
    """Assess all sizes and alloys for a request. Long work; after a stop it returns the finished candidates.

    {"fields": {"force": "8 N", …}} -> {"asked": {…}, "columns": […], "candidates": [{…}], …}

    Notes: {"done": candidates, "of": candidates}.
    """
    wire, catalogue = read_request(request), load_wires()
    total = len(list_sizes(wire, catalogue)) * len(wire.alloys())
    desk.tell({"done": 0, "of": total})
    sizing = size_wire(wire, catalogue, lambda done, of: desk.tell({"done": done, "of": of}), desk.stop.is_set)
    return {
        "asked": read_fields(request),
        "columns": [" ".join(name.split("\n")).strip() for name in words.choose_columns(wire)],
        "candidates": [
            _describe_candidate(wire, number, candidate, catalogue)
            for number, candidate in enumerate(sizing.candidates, start=1)
        ],
        "of": total,
    }


def _describe_candidate(request: WireRequest, number: int, candidate: Candidate, catalogue: WireCatalogue) -> JsonTable:
    limits = list_margins(request, candidate)
    text, refused = _write_scenario(request, candidate, catalogue)
    return {
        **candidate.to_dict(),
        "cells": words.list_cells(number, candidate),
        "headline": words.write_headline(candidate),
        "sentences": list(words.list_sentences(request, candidate)),
        "doubts": words.list_doubts(candidate),
        "margins": [_describe_margin(limit) for limit in limits],
        "tightest": _describe_margin(find_tightest(limits)),
        "scenario": text,
        "loop": None if text is None else format_loop(request, candidate, text),
        "no_scenario": refused,
    }


def _describe_margin(margin: Margin) -> JsonTable:
    display_unit = "" if margin.unit == margin.display_unit == "1" else margin.display_unit
    used, limit = (
        f"{units.from_si(value, margin.display_unit, margin.unit):.3g}" for value in (margin.used, margin.limit)
    )
    return {
        "name": margin.name,
        "share": margin.share,
        "used": used,
        "limit": limit,
        "unit": display_unit,
        "chosen": margin.chosen,
    }


def _write_scenario(request: WireRequest, candidate: Candidate, catalogue: WireCatalogue) -> tuple[str | None, str]:
    try:
        return format_scenario(request, candidate, catalogue), ""
    except InputError as error:
        return None, str(error)


CATALOGUE_FIELDS = ("stress", "ambient", "alloy")


def compare_catalogue(request: Request, desk: Desk) -> JsonTable:
    """Compare the model with the maker's table. Long work; after a stop it returns the finished rows.

    {"fields": {"stress": …, "ambient": …, "alloy": …}} -> {"columns": […], "rows": [[…]], …}

    Notes: {"done": rows, "of": rows}.
    """
    given = {name: text for name, text in read_fields(request).items() if name in CATALOGUE_FIELDS}
    fields, refused = convert_fields(given)
    if refused:
        raise ParameterError(" ".join(refused.values()))
    alloy = fields.get("alloy", "any")
    stress, ambient = fields.get("stress", STRESS), fields.get("ambient", AMBIENT)
    rows = check_catalogue(
        alloys=ALLOYS if alloy == "any" else (alloy,),
        stress=stress,
        ambient=ambient,
        progress=lambda done, of: desk.tell({"done": done, "of": of}),
        stop=desk.stop.is_set,
    )
    return {
        "asked": given,
        "conditions": words.write_conditions(stress, ambient),
        "columns": [" ".join(name.split("\n")).strip() for name in words.CHECKED],
        "rows": [words.list_check_cells(row) for row in rows],
        "spread": words.list_spreads(rows),
        "doubt": words.DOUBT,
    }
