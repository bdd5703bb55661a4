"""The whole benchmark: entries × tasks × wires × faults, and the rows of its table."""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, fields
from importlib.metadata import version
from itertools import pairwise
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

    def prepare_runs(self, tasks: Sequence[BenchmarkTask], wires: int, faulty: bool, seed: int = SEED) -> PlantRuns:
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
    itae: float = math.nan
    """Median of ∫ t |e| dt from each jump on, over the span [s²]."""
    activity: float = math.nan
    """Median of the mean change of a duty from period to period."""
    cost: float = math.nan
    """Computing time of a period of one wire, plant included [s]."""


@dataclass(frozen=True, eq=False)
class BenchmarkTable:
    """All that was measured, and the rows made of it."""

    rows: tuple[BenchmarkRow, ...]
    measures: Mapping[tuple[str, str, str], Mapping[str, Numbers]]
    """Of every wire, by entry, task and fault; empty for a table that was read."""
    version: str
    digest: str
    """Of all that defines the benchmark."""
    seed: int = SEED
    """Seed of the wires and of the noise."""

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
            "seed": self.seed,
            "ranking": [{"entry": name, "score": score} for name, score in rank_entries(self)],
            "rows": [asdict(one) for one in self.rows],
        }


def read_table(path: Path) -> BenchmarkTable:
    """A table that was saved as JSON; `DataError` if it is none."""
    try:
        given = json.loads(path.read_text(encoding="utf-8"))
        rows = tuple(BenchmarkRow(**row) for row in given["rows"])
        return BenchmarkTable(rows, {}, given["version"], given["digest"], given.get("seed", SEED))
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
    seed: int = SEED,
    workers: int = 2,
    tell: Callable[[int, int], None] | None = None,
) -> BenchmarkTable:
    """Run all competitors.

    Args:
        competitors: entries of the package or others.
        tasks: of any plants.
        faults: names of faults, besides the run without one.
        wires: how many; the first ones of the benchmark if fewer, a power of 2.
        seed: of the wires and of the noise; another seed than that of the benchmark gives a held-out set.
        workers: threads; what is compiled and what runs in C goes on side by side.
        tell: called after every run with the number done and the total.
    """
    heats, names = list_heats(competitors, tasks), [NO_FAULT, *faults]
    done, total = 0, len(heats) * len(names)
    found: dict[tuple[str, str, str], dict[str, Numbers]] = {}
    with ThreadPoolExecutor(max(1, workers)) as pool:
        for batch in pool.map(lambda heat: dict(_run_heat(heat, names, wires, seed)), heats):
            found |= batch
            done += len(names)
            if tell is not None:
                tell(done, total)
    rows = tuple(_make_row(key, one) for key, one in found.items())
    return BenchmarkTable(rows, found, version("martensite"), make_digest(), seed)


def _run_heat(
    heat: BenchmarkHeat, faults: Sequence[str], wires: int, seed: int
) -> Iterator[tuple[tuple[str, str, str], dict[str, Numbers]]]:
    few = min(getattr(heat.competitor, "fault_wires", None) or wires, wires)
    runs = heat.competitor.prepare_runs(heat.tasks, wires, len(faults) > 1, seed=seed)
    for fault in faults:
        if fault != NO_FAULT and runs.wires > few:
            runs = heat.competitor.prepare_runs(heat.tasks, few, True, seed=seed)
        begun = time.thread_time()
        found, count = runs.run(fault), runs.wires
        cost = (time.thread_time() - begun) / (runs.steps * runs.lanes.lanes)
        found["cost"] = np.full(runs.lanes.lanes, cost)
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
        itae=float(np.median(one["itae"])),
        activity=float(np.median(one["activity"])),
        cost=float(np.median(one["cost"])),
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


def compare_pairs(table: BenchmarkTable) -> list[tuple[str, str, float, float]]:
    """Paired differences of neighbours in the ranking, wire by wire, without a fault.

    Returns:
        Entry, next entry, mean difference of their rms errors over common tasks and wires, in shares of the span and
        at most 1 for each run, and half the width of its 95 % interval over the wires.
    """
    names, found = table.entries, list[tuple[str, str, float, float]]()
    errors = {(e, task): one["error"] for (e, task, fault), one in table.measures.items() if fault == NO_FAULT}
    tasks = dict.fromkeys(task for _, task in errors)
    for one, other in pairwise(names):
        both = [task for task in tasks if (one, task) in errors and (other, task) in errors]
        rows = [np.minimum(errors[other, t], 1.0) - np.minimum(errors[one, t], 1.0) for t in both]
        if rows and len(rows[0]) > 1:
            wires = np.mean(rows, axis=0)
            found.append((one, other, float(wires.mean()), 1.96 * float(wires.std(ddof=1)) / math.sqrt(len(wires))))
    return found


class EntryRuns:
    """An entry of the package, or a kernel of one's own, as a competitor."""

    def __init__(self, entry: BenchmarkEntry) -> None:
        self.entry, self.name, self.title, self.plants = entry, entry.name, entry.title, entry.plants
        self.fault_wires = entry.fault_wires

    def prepare_runs(
        self, tasks: Sequence[BenchmarkTask], wires: int, faulty: bool, guard: str = SENSORS, seed: int = SEED
    ) -> PlantRuns:
        """Its runs on one plant, all in one program."""
        plant = tasks[0].plant
        bench: Bench = self.entry.build_bench(plant)
        values = self.entry.list_repetitions(tasks, wires)
        drawn = draw_wires(bench, wires, seed)
        runs = PlantRuns(bench, tasks, drawn, faulty=faulty, guard=guard, values=values, seed=seed)
        runs.set_references(*find_scale(self.entry.list_numbers(plant)))
        return runs


def list_faults() -> list[str]:
    """Names of the faults of the benchmark."""
    return list(FAULT_CASES)


COLUMNS = tuple(one.name for one in fields(BenchmarkRow))
