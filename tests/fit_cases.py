"""Scenarios that follow logs, and logs made with numbers that are known."""

from __future__ import annotations

import csv
import math
import random
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from one_wire import write_wire

from martensite.base import units
from martensite.scenario.scenario import read_scenario
from martensite.signals.records import Record
from martensite.simulate.api import simulate

ISOBARIC = write_wire(
    "Isobaric test",
    diameter="0.381 mm",
    length="100 mm",
    cooling="",
    mechanism='kind = "testing-machine"\ncontrol = "stress"\nsection = "0.1140092 mm^2"\n'
    '\n[signals.command]\nkind = "log"',
    drive='kind = "temperature"\nwaveform = { kind = "log" }',
    run="",
)
HEATED = write_wire("Wire against a spring", drive='kind = "current"\nwaveform = "log"', run="tolerance = 1e-3")
TRUTH: Mapping[str, Any] = {"element.law.A_s": "72 degC", "element.law.A_f": "84 degC"}
TRUE = {"A_s": 345.15, "A_f": 357.15}
HEAT_TRUTH: Mapping[str, Any] = {"environment.cooling.h": "80 W/m^2/K"}

Rows = list[list[str]]


def cycle(stress: float = 100e6, rows: int = 121) -> Record:
    """Temperature up and down once under a stress that is not quite constant."""
    half = (rows - 1) / 2
    return Record(
        "cycle",
        {
            "time": [float(k) for k in range(rows)],
            "temperature": [300.0 + 100.0 * (1.0 - abs(k - half) / half) for k in range(rows)],
            "stress": [stress * (1.0 + 0.02 * math.sin(k / 7.0)) for k in range(rows)],
        },
        {"time": "s", "temperature": "K", "stress": "Pa"},
    )


def pulse(current: float = 0.55, rows: int = 151) -> Record:
    """A current that is switched on from 1 to 7 s."""
    times = [0.1 * k for k in range(rows)]
    level = [current if 1.0 <= t < 7.0 else 0.05 for t in times]
    return Record("pulse", {"time": times, "current": level}, {"time": "s", "current": "A"})


def measured(
    drive: Record, scenario: str, outputs: Sequence[str], truth: Mapping[str, Any], noise: float = 0.0, seed: int = 1
) -> Record:
    """A log: what drives, and what a scenario with other numbers makes of it.

    `noise` is that of every output as a share of its range.
    """
    one = read_scenario(scenario, None, truth, log=drive)
    run = simulate(one.system, one.waveform, drive.times[-1], step=0.01, samples=len(drive))
    chance = random.Random(seed)
    columns, spelt = dict(drive.columns), dict(drive.units)
    for name in outputs:
        size = noise * run.range(name)
        columns[name] = [x + chance.gauss(0.0, size) for x in run[name]]
        spelt[name] = run.unit(name)
    return Record(drive.name, columns, spelt)


@cache
def isobaric(stress: float = 100e6, noise: float = 0.01, seed: int = 1) -> Record:
    """A log of an isobaric test."""
    return measured(cycle(stress), ISOBARIC, ["strain"], TRUTH, noise, seed)


@cache
def heated(current: float = 0.55, noise: float = 0.01) -> Record:
    """A log of a wire that a current heats."""
    return measured(pulse(current), HEATED, ["position", "resistance"], HEAT_TRUTH, noise)


def repeated(record: Record, times: int) -> Record:
    """A record several times in a row: a fit of it takes that much longer."""
    count, columns = len(record), {n: list(c) * times for n, c in record.columns.items()}
    last = record.times[-1] + record.times[1] - record.times[0]
    columns["time"] = [t + (k // count) * last for k, t in enumerate(columns["time"])]
    return Record(record.name, columns, record.units)


def write_log(record: Record, path: str | Path, begin: float = 0.0) -> str:
    """Write a record as a table with headings, in the units people use."""
    table: list[list[str]] = []
    for name, column in record.columns.items():
        unit = record.units[name]
        spelling = "%" if name == "strain" else units.choose_readable_unit(unit)
        shift = begin if name == "time" else 0.0
        numbers = [f"{units.from_si(x + shift, spelling, unit):.8g}" for x in column]
        table.append([f"{name} [{spelling}]" if spelling != "1" else name, *numbers])
    write_rows(path, [list(row) for row in zip(*table, strict=True)])
    return str(path)


def read_rows(path: str | Path) -> Rows:
    """The cells of a table, headings first."""
    with Path(path).open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


def write_rows(path: str | Path, rows: Rows) -> str:
    """Write cells as a table."""
    with Path(path).open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows(rows)
    return str(path)


def edited(path: str, change: Callable[[Rows], Rows], to: str = "edited.csv") -> str:
    """A copy of a table with its cells changed."""
    return write_rows(to, change(read_rows(path)))
