"""Scenarios that follow a column of a log; and such a scenario with its log inside.

On the bench, the followed column becomes a waveform of listed times.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, cast

from martensite.app.messages import JsonTable, Request
from martensite.app.views.columns import find_corners
from martensite.base import units
from martensite.base.errors import ParameterError
from martensite.base.files import toml_document
from martensite.base.toml_text import as_toml
from martensite.physics.electrical.base import SOURCES
from martensite.scenario.assemble import GROUP, SIGNALS, drive_section, waveform_path
from martensite.scenario.overrides import change_document
from martensite.scenario.recorded_waveforms import KIND, LOG, NATURAL, from_zero, hold_levels
from martensite.scenario.scenario import Scenario
from martensite.signals.records import Record
from martensite.signals.table import Table
from martensite.simulate.drive_waveforms import by_name

WAVEFORM = "waveform"
SOURCE_OF = {"V": "voltage", "A": "current", "W": "power", "K": "temperature"}
"""Source by unit of a column."""


def describe_drives(document: Request) -> list[dict[str, str]]:
    """Return the drives that can follow a column: path of the waveform, kind of source, followed column."""
    return [_describe_drive(path, table) for path, table in _list_driven(document)]


def _list_driven(document: Request) -> Iterator[tuple[str, Request]]:
    """Yield the path of each waveform, and its table."""
    drive = drive_section(document)
    if isinstance(document.get(drive), dict):
        yield f"{drive}.{WAVEFORM}", document[drive]
    for port, table in _list_tables(document.get(GROUP)):
        if WAVEFORM in dict(_list_tables(table)).get(drive, {}):
            yield f"{GROUP}.{port}.{drive}.{WAVEFORM}", table[drive]
    for name, table in _list_tables(document.get(SIGNALS)):
        yield f"{SIGNALS}.{name}", {WAVEFORM: table}


def _list_tables(given: Any) -> Iterator[tuple[str, JsonTable]]:
    for name, table in cast("JsonTable", given if isinstance(given, dict) else {}).items():
        if isinstance(table, dict):
            yield name, cast("JsonTable", table)


def _describe_drive(path: str, table: Request) -> dict[str, str]:
    given = table.get(WAVEFORM)
    waveform = cast("JsonTable", given if isinstance(given, dict) else {"kind": given})
    kind = str(table.get("kind", ""))
    natural = NATURAL.get(SOURCES[kind].unit, "") if kind in SOURCES.names() else ""
    followed = str(waveform.get("column", natural)) if waveform.get("kind") == LOG else ""
    signal = path.startswith(f"{SIGNALS}.")
    return {
        "path": path,
        "kind": kind,
        "waveform": str(waveform.get("kind") or ""),
        "column": followed,
        "what": f"signal `{path.rpartition('.')[2]}`" if signal else f"drive `{kind}`",
    }


def follow_column(document: JsonTable, path: str, column: str, unit: str) -> JsonTable:
    """Return a scenario whose drive or signal follows a column of a log.

    A source of another unit is replaced. A fixed duration is removed: the run takes as long as the log.
    """
    driven = dict(_list_driven(document))
    if path not in driven:
        raise ParameterError(f"The scenario has no drive or signal at `{path}`.")
    waveform = {"kind": LOG, "column": column}
    kind, changes = str(driven[path].get("kind", "")), {path: waveform}
    fits = kind in SOURCES.names() and SOURCES[kind].unit == unit
    if not fits and not path.startswith(f"{SIGNALS}."):
        if unit not in SOURCE_OF:
            raise ParameterError(
                f"No source takes `{column}`, which is in {unit}; a drive follows a voltage, "
                "a current, a power, or a temperature."
            )
        above = path.rpartition(".")[0]
        changes = {above: {"kind": SOURCE_OF[unit], WAVEFORM: waveform}}
    followed = change_document(document, changes)
    run = followed.get("run")
    if isinstance(run, dict):
        cast("JsonTable", run).pop("duration", None)
    return followed


def embed_log(scenario: Scenario, log: Record, numbers: Mapping[str, str]) -> str:
    """Return the document of a scenario with other values, independent of the log.

    Args:
        scenario: scenario that can follow a log.
        log: followed log.
        numbers: texts of quantities by dotted path.
    """
    record, section = from_zero(log), scenario.places.drive
    changes: JsonTable = dict(numbers)
    for name, column in scenario.follows.items():
        path = waveform_path(scenario.system, name, section).removesuffix(".")
        table = by_name(scenario.system, scenario.waveform)[name]
        changes[path] = _list_corners(record, column, isinstance(table, Table) and len(table.times) > len(record) + 1)
    document = change_document(toml_document(scenario.text), changes)
    run = document.get("run")
    if scenario.follows and isinstance(run, dict):
        cast("JsonTable", run).pop("lead", None)
    return as_toml(document)


def _list_corners(record: Record, column: str, is_stepped: bool) -> JsonTable:
    """Return a waveform through the corners of a column, optionally constant between rows."""
    entries = [(t, x) for t, x in zip(record.times.tolist(), record[column].tolist(), strict=True) if math.isfinite(x)]
    entries = hold_levels(entries) if is_stepped else entries
    times, values = zip(*entries, strict=True)
    rows, unit = find_corners(times, values), record.units[column]
    spelling = units.choose_readable_unit(unit)
    label = "" if spelling == "1" else f" {spelling}"
    return {
        "kind": KIND,
        "times": [f"{times[row]:.10g} s" for row in rows],
        "values": [f"{units.from_si(values[row], spelling, unit):.6g}{label}" for row in rows],
    }
