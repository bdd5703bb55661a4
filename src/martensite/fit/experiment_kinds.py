"""Kind of experiment in a set of logs, from columns, units, and variation.

    stroke          a drive moves what the element carries
    blocked-force   a drive makes a force at constant length
    heating         a drive heats an element whose temperature is measured
    resistance      a drive heats an element whose resistance is measured
    isobaric        heated and cooled under constant loads, strain measured
    isothermal      drawn and released at a constant temperature, stress measured
    cooling         left to cool without a drive, temperature measured

A varying drive decides first, then the other measured columns. A column varies if its range exceeds its scatter from
row to row and is not small compared with its level.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.base.errors import DataError, require_known
from martensite.scenario.layout import list_quantities
from martensite.search.quantity_text import list_names
from martensite.signals.records import Record

KINDS = {
    "stroke": "a drive moves what the element carries",
    "blocked-force": "a drive makes a force at constant length",
    "heating": "a drive heats an element whose temperature is measured",
    "resistance": "a drive heats an element whose resistance is measured",
    "isobaric": "heated and cooled under constant loads",
    "isothermal": "drawn and released at a constant temperature",
    "cooling": "left to cool without a drive",
}
DRIVES, DEFORMATIONS, LOADS = map(list_quantities, ("drive", "shape", "load"))
DRIVEN = {"stroke": DEFORMATIONS, "blocked-force": LOADS, "heating": ("temperature",), "resistance": ("resistance",)}
"""Driven experiment -> columns, one of which it measures."""
NOISE, LEVEL = 6.0, 0.02
"""A range is a signal beyond so many scatters from row to row, and beyond this share of its level."""
LOADED = 0.5
"""Range of a load over its largest value above which the load is not constant."""
HEATED = 15.0
"""Range of a temperature above which the temperature is not constant [K]."""
NEEDS = {
    "stroke": "a drive (voltage, current, power or duty) and a position, or strain, that vary",
    "blocked-force": "a drive and a force that vary",
    "heating": "a drive and a temperature that vary",
    "resistance": "a drive and a resistance that vary",
    "isobaric": "a temperature that varies by more than 15 K and a strain or position",
    "isothermal": "strain and stress (or elongation and force) that vary",
    "cooling": "a temperature that falls, and times",
}


@dataclass(frozen=True)
class ExperimentKind:
    """Kind of experiment of the logs."""

    name: str
    why: str
    """One sentence."""
    drive: str = ""
    """Column that drives; empty for none."""
    measured: tuple[str, ...] = ()
    """Columns that are to be explained, the most telling first."""


def find_varying(records: Sequence[Record]) -> list[str]:
    """Return the columns that vary in at least one record, in their order."""
    names = dict.fromkeys(name for record in records for name in record.columns if name != "time")
    return [name for name in names if any(_is_varying(name, r[name]) for r in records if name in r.columns)]


def _is_varying(name: str, column: Any) -> bool:
    x = np.asarray(column, float)
    x = x[np.isfinite(x)]
    if x.size < 2 or np.ptp(x) == 0.0:
        return False
    if name == "temperature":
        return bool(np.ptp(x) > 1.0)
    scatter = float(np.median(np.abs(np.diff(x))))
    low, high = np.percentile(x, (0.5, 99.5)) if scatter > 0.0 else (x.min(), x.max())
    return bool(high - low > max(NOISE * scatter if x.size > 50 else 0.0, LEVEL * np.abs(x).max()))


def recognise_experiment(records: Sequence[Record], asked: str | None = None) -> ExperimentKind:
    """Which experiment some records hold.

    Args:
        records: in SI.
        asked: the kind, where it is known.

    Raises:
        DataError: it cannot be told, or the columns of the kind that is asked for are missing.
    """
    if asked is not None:
        require_known("experiment", asked, KINDS)
    varying = find_varying(records)
    found = list(_list_possible(records, varying))
    if asked is not None:
        found = [one for one in found if one.name == asked]
    if found:
        return found[0]
    held = list_names([n for n in dict.fromkeys(n for r in records for n in r.columns) if n != "time"])
    if asked is not None:
        raise DataError(
            f"The logs are no `{asked}` experiment, which needs {NEEDS[asked]}; they hold {held}, of which vary "
            f"{list_names(varying) or 'none'}."
        )
    raise DataError(
        f"What the logs were recorded from cannot be told: they hold {held}, of which vary "
        f"{list_names(varying) or 'none'}. Known are {'; '.join(f'`{k}`, {v}' for k, v in KINDS.items())}. Name the "
        "columns (`--as`), or write a scenario (--scenario)."
    )


def _list_possible(records: Sequence[Record], varying: Sequence[str]) -> Any:
    """Return all kinds that the columns allow, the most telling first."""
    drives = [name for name in DRIVES if name in varying]
    shapes, loads = ([n for n in group if n in varying] for group in (DEFORMATIONS, LOADS))
    if drives:
        yield from _list_driven(records, varying, drives)
    kelvin = _find_range(records, "temperature")
    load = max((_share_range(records, name) for name in loads), default=0.0)
    warm = "temperature" in varying and kelvin > HEATED
    if shapes and warm and load < LOADED:
        said = f"the temperature goes over {kelvin:.0f} K while the load rests"
        yield ExperimentKind("isobaric", f"`{shapes[0]}` and `temperature` vary, {said}", "temperature", (shapes[0],))
    if shapes and loads and load >= LOADED:
        said = "no drive varies" + (", nor does the temperature" if not warm else "")
        yield ExperimentKind(
            "isothermal", f"{list_names([shapes[0], loads[0]])} vary, {said}", shapes[0], (loads[0], shapes[0])
        )
    falls = all(_is_falling(record["temperature"]) for record in records if "temperature" in record.columns)
    if warm and falls and not shapes and not drives:
        yield ExperimentKind("cooling", f"only `temperature` varies, over {kelvin:.0f} K", "", ("temperature",))


def _is_falling(column: Any) -> bool:
    """Return whether a temperature ends well below where it begins."""
    x = np.asarray(column, float)
    x = x[np.isfinite(x)]
    return bool(x.size > 1 and x[0] - x[-1] > 0.5 * np.ptp(x))


def _list_driven(records: Sequence[Record], varying: Sequence[str], drives: Sequence[str]) -> Any:
    drive = min(drives, key=lambda name: (_count_levels(records, name), DRIVES.index(name)))
    for kind, names in DRIVEN.items():
        there = [name for name in names if name in varying]
        if there:
            more = [n for n in LOADS if n in varying] if kind == "stroke" else []
            measured = (there[0], *more[:1])
            yield ExperimentKind(kind, f"`{drive}` drives, {list_names(list(measured))} vary", drive, measured)
    rest = [name for name in drives if name != drive and name in ("voltage", "current")]
    if rest:
        yield ExperimentKind(
            "resistance", f"`{drive}` drives, and `{rest[0]}` answers through the resistance", drive, (rest[0],)
        )


def _count_levels(records: Sequence[Record], name: str) -> int:
    """Return different values of a column: a command has few, what answers to it has many."""
    return sum(len(set(np.round(r[name], 12))) for r in records if name in r.columns)


def _find_range(records: Sequence[Record], name: str) -> float:
    return max((float(np.nanmax(r[name]) - np.nanmin(r[name])) for r in records if name in r.columns), default=0.0)


def _share_range(records: Sequence[Record], name: str) -> float:
    """Return the range of a column over its largest value, without the outermost hundredths."""
    shares = [0.0]
    for record in records:
        if name in record.columns:
            low, high = np.nanpercentile(record[name], (2.0, 98.0))
            shares.append(float(high - low) / max(abs(low), abs(high), 1e-300))
    return max(shares)
