"""How the numbers of entries were found: the same search for all, on the nominal wire alone.

The cost is the mean rms error over the training tasks of a plant, in shares of their span, plus a share for every
kelvin above `BELOW` the limit, and 1 for an alarm; none of these tasks is one of the benchmark. The search is the
cross-entropy method (de Boer et al. (2005)): `CANDIDATES` sets of numbers side by side in C, drawn from a scrambled
Sobol' sequence first and around the best `ELITE` of all then, for `ROUNDS` rounds, on logarithms of what keeps a sign.
Every entry gets as many runs, whatever it is; one that says `rounds`, for its runs are long, gets fewer.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.control.entries import BenchmarkEntry, find_scale, find_span
from benchmarks.control.runs import PlantRuns
from benchmarks.control.tasks import TRAINING, load_tasks
from benchmarks.control.wires import draw_wires
from martensite.base.summary import DataTable, Summary
from martensite.search.starts import draw_points

Numbers = NDArray[np.float64]
CANDIDATES, ELITE, ROUNDS, SEED = 64, 8, 30, 1
LEAST_SPREAD = 0.01
"""Least standard deviation of a draw, in shares of the range, until the last third of the rounds."""
BELOW, PER_KELVIN = 25.0, 0.01
"""How far below the limit temperatures cost nothing [K], and what a kelvin costs."""


@dataclass(frozen=True)
class FoundGains:
    """Numbers of an entry on a plant."""

    numbers: dict[str, float]
    cost: float
    source: str
    """How they were found."""


def search_gains(
    entry: BenchmarkEntry,
    plant: str,
    *,
    candidates: int = CANDIDATES,
    rounds: int | None = None,
    tell: Callable[[int, float], None] | None = None,
) -> FoundGains:
    """Numbers of an entry that do best on the training tasks of a plant with its nominal wire.

    Args:
        entry: what is tuned.
        plant: name of the plant.
        candidates: sets of numbers in a round.
        rounds: how often sets are drawn; by default as often as for the others, or as the entry says.
        tell: called after every round with its number and the least cost so far.
    """
    rng, bench = np.random.default_rng(SEED), entry.build_bench(plant, {})
    tasks = [one for one in load_tasks(TRAINING).values() if one.plant == plant]
    wires = {path: np.repeat(row, candidates) for path, row in draw_wires(bench, 1).items()}
    runs = PlantRuns(bench, tasks, wires, faulty=False, values=entry.list_repetitions(tasks, candidates))
    places = draw_points(len(entry.free), candidates, SEED)
    rounds = rounds or entry.rounds or ROUNDS
    best, costs, spread = places, np.full(candidates, np.inf), LEAST_SPREAD
    for k in range(rounds):
        found = _judge_places(entry, plant, runs, places)
        best, costs = np.concatenate([best, places]), np.concatenate([costs, found])
        order = np.argsort(costs, kind="stable")[:ELITE]
        best, costs = best[order], costs[order]
        spread = LEAST_SPREAD if k < 2 * rounds // 3 else 0.1 * LEAST_SPREAD
        wide = np.maximum(best.std(axis=0), spread)
        places = np.clip(best.mean(axis=0) + wide * rng.standard_normal((candidates, len(entry.free))), 0.0, 1.0)
        if tell is not None:
            tell(k + 1, float(costs[0]))
    numbers = _convert_places(entry, plant, best[:1])
    source = SOURCE.format(rounds=rounds, candidates=candidates, seed=SEED)
    return FoundGains({name: float(f"{row[0]:.5g}") for name, row in numbers.items()}, float(costs[0]), source)


def _convert_places(entry: BenchmarkEntry, plant: str, places: Numbers) -> dict[str, Numbers]:
    span = find_span(plant)
    return {one.name: np.asarray(one.convert(row, span)) for one, row in zip(entry.free, places.T, strict=True)}


def _judge_places(entry: BenchmarkEntry, plant: str, runs: PlantRuns, places: Numbers) -> Numbers:
    """Costs of sets of numbers, given in shares of their ranges, shape (sets,)."""
    numbers, tasks = entry.list_numbers(plant, _convert_places(entry, plant, places)), len(runs.tasks)
    placed = entry.place_numbers(plant, numbers)
    runs.lanes.set_values({path: np.tile(row, tasks) if np.ndim(row) else row for path, row in placed.items()})
    runs.set_references(*(np.tile(row, tasks) if np.ndim(row) else row for row in find_scale(numbers)))
    found = runs.run()
    hot = np.maximum(found["hottest"] - float(runs.limits.min()) + BELOW, 0.0)
    each = np.where(np.isfinite(found["error"]), found["error"], 10.0) + PER_KELVIN * hot + found["alarm"]
    return each.reshape(tasks, -1).mean(axis=0)


HEAD = """# Numbers of the entries of the benchmark of control, on the nominal wire of each plant: written by
# `python -m benchmarks.control tune --save gains.toml`, whose search `search.py` describes. Rows are in SI; `cost` is
# the lowest cost of the search.
"""


def format_gains(found: Mapping[tuple[str, str], FoundGains]) -> str:
    """The text of `gains.toml`, of numbers by entry and plant."""
    lines = [HEAD]
    for (entry, plant), one in sorted(found.items()):
        lines += [f"[{entry}.{plant}]", 'kind = "fitted"', f'source = "{one.source}"', f"cost = {one.cost:.5g}"]
        rows = ", ".join(f'"{name}" = {value!r}' for name, value in one.numbers.items())
        lines += [f"numbers = {{ {rows} }}", ""]
    return "\n".join(lines)


SOURCE = "cross-entropy search, {rounds} rounds of {candidates}, training tasks, nominal wire, seed {seed}"


def read_found(path: Path) -> dict[tuple[str, str], FoundGains]:
    """What a file of gains holds, by entry and plant."""
    given = tomllib.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return {
        (entry, plant): FoundGains(one["numbers"], one["cost"], one["source"])
        for entry, plants in given.items()
        for plant, one in plants.items()
    }


def summarise_gains(found: Mapping[tuple[str, str], FoundGains]) -> Summary:
    """Costs of numbers by entry and plant; the numbers themselves are for programs."""
    rows = [(entry, plant, f"{one.cost:.4g}") for (entry, plant), one in sorted(found.items())]
    data = [{"entry": e, "plant": p, "cost": one.cost, "numbers": one.numbers} for (e, p), one in found.items()]
    return Summary("", [DataTable(("entry", "plant", "cost"), rows, right=(2,))], {"gains": data})
