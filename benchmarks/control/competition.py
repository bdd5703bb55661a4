"""The whole benchmark: entries × tasks × wires × faults, and the rows of its table."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, fields
from importlib.metadata import version
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from benchmarks.control.entries import BenchmarkEntry, find_scale
from benchmarks.control.faults import BEGIN, FAULT_CASES, OVER
from benchmarks.control.guards import MARGIN, SENSORS
from benchmarks.control.runs import MEASURES, NO_FAULT, PlantRuns
from benchmarks.control.tasks import FOLDER, ORDER, BenchmarkTask
from benchmarks.control.wires import AMBIENT, COUNT, DIAMETER, FILM, RESISTIVITY, SEED, TEMPERATURES, draw_wires
from martensite.base.errors import DataError
from martensite.control.loop.bench import Bench

Numbers = NDArray[np.float64]
MEDIAN, MOST = 50.0, 90.0
"""Percentiles of the table."""


class Competitor(Protocol):
    """Whoever takes part: an entry of the package, or one of a stranger."""

    name: str
    title: str
    plants: tuple[str, ...]

    def prepare_runs(self, tasks: Sequence[BenchmarkTask], wires: int, faulty: bool) -> PlantRuns:
        """Its runs on one plant."""
        ...


@dataclass(frozen=True)
class BenchmarkRow:
    """What one entry did on one task under one fault: over all wires."""

    entry: str
    task: str
    fault: str
    wires: int
    error_median: float
    """Rms error in shares of the span asked for."""
    error_90: float
    settling: float
    """Median [s]."""
    overshoot: float
    """Median, in shares of the span."""
    energy: float
    """Median [J]."""
    hottest: float
    """Highest temperature of any wire [K]."""
    above: float
    """Share of the wires above their temperature limit at some time."""
    alarms: float
    """Share of the wires whose guard cut."""
    failed: float
    """Share of the wires whose run has no result."""


@dataclass(frozen=True, eq=False)
class BenchmarkTable:
    """All that was measured, and the rows made of it."""

    rows: tuple[BenchmarkRow, ...]
    measures: Mapping[tuple[str, str, str], Mapping[str, Numbers]]
    """Of every wire, by entry, task and fault; empty for a table that was read."""
    version: str
    digest: str
    """Of all that defines the benchmark."""

    @property
    def entries(self) -> list[str]:
        """Names of entries, the best first."""
        return [name for name, _ in rank_entries(self)]

    def select(self, **names: str) -> list[BenchmarkRow]:
        """Rows by `entry`, `task` or `fault`."""
        return [one for one in self.rows if all(getattr(one, key) == name for key, name in names.items())]

    def to_json(self) -> dict[str, Any]:
        """Numbers and where they come from, ready for JSON."""
        return {
            "version": self.version,
            "digest": self.digest,
            "ranking": [{"entry": name, "score": score} for name, score in rank_entries(self)],
            "rows": [asdict(one) for one in self.rows],
        }


def read_table(path: Path) -> BenchmarkTable:
    """A table that was saved as JSON; `DataError` if it is none."""
    try:
        given = json.loads(path.read_text(encoding="utf-8"))
        rows = tuple(BenchmarkRow(**row) for row in given["rows"])
        return BenchmarkTable(rows, {}, given["version"], given["digest"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DataError(f"`{path}` is no table of the benchmark: {error}.") from None


def make_digest() -> str:
    """A digest of plants, tasks, wires, faults and guard: who has the same ran the same benchmark."""
    drawn = (COUNT, SEED, RESISTIVITY, TEMPERATURES, FILM, DIAMETER, AMBIENT)
    found = hashlib.sha256(repr((drawn, BEGIN, OVER, sorted(FAULT_CASES.items()), MARGIN)).encode())
    for path in sorted((*FOLDER.glob("plants/*.toml"), *FOLDER.glob("tasks/*.toml"))):
        found.update(path.name.encode() + path.read_bytes())
    return found.hexdigest()[:12]


@dataclass(frozen=True)
class BenchmarkHeat:
    """The tasks of one plant for one competitor."""

    competitor: Any
    tasks: tuple[BenchmarkTask, ...]


def list_heats(competitors: Sequence[Any], tasks: Sequence[BenchmarkTask]) -> list[BenchmarkHeat]:
    """What there is to run."""
    found: list[BenchmarkHeat] = []
    for one in competitors:
        for plant in ORDER:
            own = tuple(task for task in tasks if task.plant == plant)
            if own and plant in one.plants:
                found.append(BenchmarkHeat(one, own))
    return found


def run_benchmark(
    competitors: Sequence[Any],
    tasks: Sequence[BenchmarkTask],
    faults: Sequence[str] = (),
    wires: int = COUNT,
    *,
    workers: int = 2,
    tell: Callable[[int, int], None] | None = None,
) -> BenchmarkTable:
    """Run all competitors.

    Args:
        competitors: entries of the package or others.
        tasks: of any plants.
        faults: names of faults, besides the run without one.
        wires: how many; the first ones of the benchmark if fewer, a power of 2.
        workers: threads; what is compiled and what runs in C goes on side by side.
        tell: called after every run with the number done and the total.
    """
    heats, names = list_heats(competitors, tasks), [NO_FAULT, *faults]
    done, total = 0, len(heats) * len(names)
    found: dict[tuple[str, str, str], dict[str, Numbers]] = {}
    with ThreadPoolExecutor(max(1, workers)) as pool:
        for batch in pool.map(lambda heat: dict(_run_heat(heat, names, wires)), heats):
            found |= batch
            done += len(names)
            if tell is not None:
                tell(done, total)
    rows = tuple(_make_row(key, one) for key, one in found.items())
    return BenchmarkTable(rows, found, version("martensite"), make_digest())


def _run_heat(
    heat: BenchmarkHeat, faults: Sequence[str], wires: int
) -> Iterator[tuple[tuple[str, str, str], dict[str, Numbers]]]:
    few = min(getattr(heat.competitor, "fault_wires", None) or wires, wires)
    runs = heat.competitor.prepare_runs(heat.tasks, wires, len(faults) > 1)
    for fault in faults:
        if fault != NO_FAULT and runs.wires > few:
            runs = heat.competitor.prepare_runs(heat.tasks, few, True)
        found, count = runs.run(fault), runs.wires
        for k, task in enumerate(heat.tasks):
            own = slice(k * count, (k + 1) * count)
            yield (heat.competitor.name, task.name, fault), {name: found[name][own] for name in MEASURES}


def _make_row(key: tuple[str, str, str], one: Mapping[str, Numbers]) -> BenchmarkRow:
    error = one["error"]
    ninety = float(np.percentile(error, MOST, method="higher"))
    return BenchmarkRow(
        *key,
        wires=len(error),
        error_median=float(np.percentile(error, MEDIAN, method="higher")),
        error_90=ninety,
        settling=float(np.median(one["settling"])),
        overshoot=float(np.median(one["overshoot"])),
        energy=float(np.median(one["energy"])),
        hottest=float(np.max(one["hottest"])),
        above=float(np.mean(one["above"])),
        alarms=float(np.mean(one["alarm"])),
        failed=float(np.mean(one["failed"])),
    )


def rank_entries(table: BenchmarkTable) -> list[tuple[str, float]]:
    """Entries and their scores, the best first.

    The score is the mean over the tasks of the 90 % rms error without a fault, in shares of the span; a task that an
    entry has not, or on which its error is larger, counts as 1. Entries that let a wire above its limit without a
    fault come last.
    """
    sound = table.select(fault=NO_FAULT)
    tasks = list(dict.fromkeys(one.task for one in sound))
    scores: dict[str, tuple[bool, float]] = {}
    for name in dict.fromkeys(one.entry for one in sound):
        own = {one.task: one for one in sound if one.entry == name}
        score = sum(min(own[task].error_90, 1.0) if task in own else 1.0 for task in tasks) / len(tasks)
        scores[name] = any(one.above > 0.0 for one in own.values()), score
    return [(name, score) for name, (_, score) in sorted(scores.items(), key=lambda row: row[1])]


class EntryRuns:
    """An entry of the package, or a kernel of one's own, as a competitor."""

    def __init__(self, entry: BenchmarkEntry) -> None:
        self.entry, self.name, self.title, self.plants = entry, entry.name, entry.title, entry.plants
        self.fault_wires = entry.fault_wires

    def prepare_runs(self, tasks: Sequence[BenchmarkTask], wires: int, faulty: bool, guard: str = SENSORS) -> PlantRuns:
        """Its runs on one plant, all in one program."""
        plant = tasks[0].plant
        bench: Bench = self.entry.build_bench(plant)
        values = self.entry.list_repetitions(tasks, wires)
        runs = PlantRuns(bench, tasks, draw_wires(bench, wires), faulty=faulty, guard=guard, values=values)
        runs.set_references(*find_scale(self.entry.list_numbers(plant)))
        return runs


def list_faults() -> list[str]:
    """Names of the faults of the benchmark."""
    return list(FAULT_CASES)


COLUMNS = tuple(one.name for one in fields(BenchmarkRow))
