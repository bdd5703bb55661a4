"""What the guards do to the entries: false alarms in hours without a fault, and how hot the twelve faults make it.

An hour is one run of 3600 s on each plant of an entry (`hours/`), of the first wires of the benchmark. A cut is a false
alarm if the same run without a guard keeps its wire within the limit. The default guard never cuts; what it does is to
limit, and that is a share of the time. How hot a fault makes it is told for the wire of the sheet, for which the bound
of that guard is made, and for wires that differ from it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.control.competition import EntryRuns, list_faults
from benchmarks.control.entries import BenchmarkEntry
from benchmarks.control.guards import DEFAULT, SENSORS, UNGUARDED
from benchmarks.control.runs import NO_FAULT
from benchmarks.control.tasks import BenchmarkTask, load_tasks
from martensite.base.errors import DataError
from martensite.base.summary import DataTable, Sentence, Summary

HOURS, HOUR_WIRES, FAULT_WIRES = "hours", 2, 8
HOUR, ZERO = 3600.0, 273.15
"""Folder of the tasks of an hour, and how many wires run in an hour, and with faults."""


@dataclass(frozen=True)
class GuardRow:
    """What a guard did to an entry."""

    entry: str
    guard: str
    hours: float
    """Without a fault, of all wires and plants."""
    cuts: int
    """Runs of an hour that it cut."""
    false_alarms: int
    """Of these, how many stay within the limit without a guard."""
    limited: float
    """Share of the hours in which it limited."""
    hottest_hour: float
    """Highest temperature without a fault [K]."""
    hottest_sheet: float
    """Highest temperature of the wire of the sheet, under the worst of all faults [K]."""
    hottest_wires: float
    """The same of wires that differ from it [K]."""


def run_guards(
    entries: Sequence[BenchmarkEntry],
    guards: Sequence[str] = (DEFAULT, SENSORS),
    faults: Sequence[str] | None = None,
    duration: float = HOUR,
    tell: Callable[[int, int], None] | None = None,
) -> list[GuardRow]:
    """Rows of all entries under some guards.

    Args:
        entries: of the benchmark.
        guards: names of guards.
        faults: names of faults; by default all of the benchmark.
        duration: of a run without a fault [s].
        tell: called after every row with the number done and the total.
    """
    found: list[GuardRow] = []
    hours = [replace(one, duration=duration) for one in load_tasks(HOURS).values()]
    for one in entries:
        for guard in guards:
            found.append(_judge_guard(EntryRuns(one), guard, list_faults() if faults is None else faults, hours))
            if tell is not None:
                tell(len(found), len(entries) * len(guards))
    return found


def _judge_guard(entry: EntryRuns, guard: str, faults: Sequence[str], hours: Sequence[BenchmarkTask]) -> GuardRow:
    own = [one for one in hours if one.plant in entry.plants]
    measured = [_run_hour(entry, one, guard) for one in own]
    kept = {name: np.concatenate([one[name] for one in measured]) for name in measured[0]}
    return GuardRow(
        entry.name,
        guard,
        hours=sum(one.duration for one in own) * HOUR_WIRES / HOUR,
        cuts=int(kept["alarm"].sum()),
        false_alarms=int(kept["false"].sum()),
        limited=float(kept["limited"].mean()),
        hottest_hour=float(kept["hottest"].max()),
        hottest_sheet=_find_hottest(entry, guard, faults, 1),
        hottest_wires=_find_hottest(entry, guard, faults, FAULT_WIRES),
    )


def _run_hour(entry: EntryRuns, task: BenchmarkTask, guard: str) -> dict[str, NDArray[np.float64]]:
    found = entry.prepare_runs([task], HOUR_WIRES, False, guard).run()
    false = np.zeros(HOUR_WIRES)
    if found["alarm"].any():
        free = entry.prepare_runs([task], HOUR_WIRES, False, UNGUARDED).run()
        false = found["alarm"] * (1.0 - free["above"])
    return {**{name: found[name] for name in ("alarm", "limited", "hottest")}, "false": false}


def _find_hottest(entry: EntryRuns, guard: str, faults: Sequence[str], wires: int) -> float:
    """Highest temperature of any wire on any task of the benchmark under any fault, or without one [K]."""
    tasks, hottest = list(load_tasks().values()), 0.0
    for plant in entry.plants:
        runs = entry.prepare_runs([one for one in tasks if one.plant == plant], wires, True, guard)
        hottest = max(hottest, *(float(runs.run(fault)["hottest"].max()) for fault in (NO_FAULT, *faults)))
    return hottest


HEAD = ("entry", "guard", "hours", "cuts", "false", "% limited", "hottest", "faults, sheet", "faults, wires")


def summarise_guards(rows: Sequence[GuardRow]) -> Summary:
    """A table of all entries and guards."""
    table = DataTable(HEAD, [_write_row(one) for one in rows], right=range(2, len(HEAD)))
    said = (
        f"Runs of an hour without a fault, of {HOUR_WIRES} wires on every plant of an entry: how many the guard cut, "
        "how many of these stay within the limit without it (false alarms), the share of the time in which it limited, "
        "and the highest temperature [°C]; then that under the worst of the faults, of the wire of the sheet and of "
        f"{FAULT_WIRES} wires that differ from it."
    )
    return Summary("", [table, Sentence(said)], {"rows": [asdict(one) for one in rows]})


def _write_row(one: GuardRow) -> list[str]:
    hot = [f"{kelvin - ZERO:.0f}" for kelvin in (one.hottest_hour, one.hottest_sheet, one.hottest_wires)]
    counts = [str(one.cuts), str(one.false_alarms), f"{100.0 * one.limited:.1f}"]
    return [one.entry, one.guard, f"{one.hours:.3g}", *counts, *hot]


def format_guards(rows: Sequence[GuardRow]) -> str:
    """JSON, a line for every row."""
    return "[\n" + ",\n".join(json.dumps(asdict(one)) for one in rows) + "\n]\n"


def read_guards(path: Path) -> list[GuardRow]:
    """Rows that were saved; `DataError` if there are none."""
    try:
        return [GuardRow(**row) for row in json.loads(path.read_text(encoding="utf-8"))]
    except (OSError, ValueError, TypeError) as error:
        raise DataError(f"`{path}` is no table of guards: {error}.") from None
