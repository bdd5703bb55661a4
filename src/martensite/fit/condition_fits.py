"""Experiments from tables of conditions: one experiment per specimen, with the rows as runs.

Rows of one condition are repeats. Their mean has the number of repeats as its weight. Their scatter about the mean,
pooled over the table, is the noise of the measure. If a column has standard deviations s, the weight of a row is n/s².

    auto     3 or more specimens: leave out each in turn; fewer: the later cycles, or a fifth of the conditions
    each     leave out every specimen in turn, from a fit to all others
    25 %     fraction of the conditions, first at the edge and in the middle
    A, B     specimens of these names
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from martensite.base.errors import DataError, InputError, ParameterError
from martensite.fit.column_matching import read_noise
from martensite.fit.condition_runs import LEAST_STEPS, ConditionExperiment, TableRow
from martensite.fit.condition_tables import ConditionTable, InputColumn, MeasureColumn, read_condition_table
from martensite.fit.free_parameters import is_nuisance, read_ranges
from martensite.fit.logs import ALL, AUTO, EACH, NONE, Log, choose_held_out, read_share
from martensite.fit.problem import Problem, build_problem
from martensite.fit.start_checks import check_start
from martensite.scenario.scenario import Scenario, load, read_scenario
from martensite.search.quantity_text import format_change
from martensite.signals.records import Record
from martensite.simulate.compiled import compile_march
from martensite.simulate.trial_runs import find_step

if TYPE_CHECKING:
    from martensite.fit.fit_task import FitTask

LEFT_OUT = 0.2
"""Default fraction of held-out conditions."""
LATER = 0.3
"""Fraction of the cycles held out from a table of cycles, the latest."""
SPECIMENS = 3
"""Number of specimens from which each is left out in turn by default."""
TRIED = 2
"""Number of rows of a specimen in the choice of a step."""
SPARE = 3
"""Number of surplus repeats from which their scatter is used as the noise of a measure."""


@dataclass(frozen=True)
class ArrangedConditions:
    """Problem, scenario of its first row, and remarks."""

    problem: Problem
    scenario: Scenario
    notes: tuple[str, ...]
    leaves_each_out: bool
    """True if every record is left out in turn."""


@dataclass(frozen=True)
class _Row:
    """Merged rows of one condition."""

    places: list[int]
    """Indices in the table."""
    values: dict[str, float]
    """Measure -> mean [SI]."""
    counts: dict[str, float]
    """Measure -> number of repeats in the mean."""


def arrange_conditions(task: FitTask) -> ArrangedConditions:
    """Return the problem of tables of conditions.

    Raises:
        InputError: a log is among the tables, or tables, scenario and free parameters are inconsistent.
        SolveError: a test run for the choice of the step fails.
    """
    all_experiments, notes, noise = list[ConditionExperiment](), list[str](), dict[str, list[tuple[float, int]]]()
    spreads, first = dict[str, float](), None
    for log in task.logs:
        scenario = _load_scenario(log)
        first = first or scenario
        table = read_condition_table(log.source, scenario, log.new_headings)  # type: ignore[arg-type]
        experiments, more = _build_experiments(table, log, scenario, task.step, noise)
        all_experiments, notes = all_experiments + experiments, [*notes, *table.notes, *more]
        spreads |= {one.words: _pool_spread(one) for one in table.measures if one.spreads}
    inputs = dict.fromkeys(p for one in all_experiments for c in one.conditions for p in c.inputs)
    scales, more = _choose_scales(all_experiments, noise)
    scales |= spreads
    notes += more
    split_experiments, turns = _choose_held_rows(all_experiments, task.hold_out)
    whole = _build_problem(task, split_experiments, scales, [*inputs])
    notes += check_start(whole.training)
    if first is None:
        raise InputError("A fit needs at least one log; none given.")
    return ArrangedConditions(whole, first, tuple(notes), turns)


def _load_scenario(log: Log) -> Scenario:
    given = log.scenario
    scenario = load(given, log.settings) if not isinstance(given, Scenario) else given
    if isinstance(given, Scenario) and log.settings:
        scenario = read_scenario(given.text, given.path, log.settings)
    if scenario.bench is not None:
        raise InputError("A table of conditions is fitted to a system without controllers, but the scenario has some.")
    return scenario.require_home("A fit")


def _build_problem(
    task: FitTask, experiments: Sequence[ConditionExperiment], scales: Mapping[str, float], inputs: Sequence[str]
) -> Problem:
    from martensite.fit.fit_task import list_paths, spell_paths

    scenario = _load_scenario(task.logs[0])
    paths, systems = list_paths(scenario), [one.system for one in experiments]
    free = read_ranges(spell_paths(task.free, paths), systems)
    outputs = {name: one for e in experiments for name, one in e.describe_outputs().items()}
    each = read_ranges(spell_paths(task.each, paths), systems, own=True, outputs=outputs)
    for wanted in each:
        if wanted.name == "delay":
            raise ParameterError("A table of conditions has no clock, and so no `delay`.")
    noise = read_noise(task.noise, outputs, {})[0]
    problem = build_problem(experiments, free, each=each, noise={**scales, **noise}, step=None)
    _refuse_set(problem, scenario, inputs)
    return problem


def _refuse_set(problem: Problem, scenario: Scenario, inputs: Sequence[str]) -> None:
    """Raise `ParameterError` if a column sets a free parameter."""
    for leaf in scenario.system.leaves():
        path = scenario.places.path(leaf.path)
        for free in problem.free:
            if path in inputs and not is_nuisance(free.path) and free.moves(leaf.path):
                raise ParameterError(f"`{free.name}` cannot be free: a column of the table sets `{path}`.")


# ---------------------------------------------------------------- rows


def _build_experiments(
    table: ConditionTable, log: Log, scenario: Scenario, step: float | None, noise: dict[str, list[tuple[float, int]]]
) -> tuple[list[ConditionExperiment], list[str]]:
    """Return one experiment for every combination of groups, and remarks on them."""
    count = len(table.measures[0].values)
    keys = list(zip(*table.groups.values(), strict=True)) if table.groups else [(log.name or table.name,)] * count
    experiments, notes = list[ConditionExperiment](), list[str]()
    for key in dict.fromkeys(keys):
        places = [k for k, one in enumerate(keys) if one == key]
        rows = _merge_repeats(table, places, noise)
        groups = dict(zip(table.groups, key, strict=True)) if table.groups else {}
        experiments.append(_build_experiment(table, log, scenario, rows, ", ".join(key), groups, step))
    merged = count - sum(len(one.record) for one in experiments)
    if merged:
        notes.append(f"{merged} rows of `{table.path.name}` are repeats: means count as many times as they are.")
    return experiments, notes


def _merge_repeats(
    table: ConditionTable, places: Sequence[int], noise: dict[str, list[tuple[float, int]]]
) -> list[_Row]:
    """Return the merged rows of each condition, ordered by their drives, with their scatter."""
    order = sorted(table.inputs, key=lambda one: not one.level)
    repeats: dict[tuple[float, ...], list[int]] = {}
    for k in places:
        repeats.setdefault(tuple(float(f"{one.values[k]:.9g}") for one in order), []).append(k)
    rows = list[_Row]()
    for _, own in sorted(repeats.items()):
        values, counts = dict[str, float](), dict[str, float]()
        for one in table.measures:
            finite_rows = [k for k in own if math.isfinite(one.values[k])]
            numbers = np.array([one.values[k] for k in finite_rows])
            weights = np.array([_weigh_row(table, one, k) for k in finite_rows])
            values[one.words] = float(np.average(numbers, weights=weights)) if finite_rows else math.nan
            counts[one.words] = float(weights.sum()) if finite_rows else 1.0
            if len(finite_rows) > 1 and not one.spreads:
                noise.setdefault(one.words, []).append(
                    (float(np.sum((numbers - numbers.mean()) ** 2)), len(finite_rows) - 1)
                )
        rows.append(_Row(own, values, counts))
    return rows


def _weigh_row(table: ConditionTable, one: MeasureColumn, k: int) -> float:
    """Return the repeats of a row, divided by its variance in units of the mean variance if known."""
    count = table.counts[k] if table.counts and math.isfinite(table.counts[k]) else 1.0
    if not one.spreads or not math.isfinite(one.spreads[k]):
        return count
    return count * _pool_spread(one) ** 2 / one.spreads[k] ** 2


def _pool_spread(one: MeasureColumn) -> float:
    """Return the standard deviation of single runs, as the root mean square of the column."""
    return math.sqrt(float(np.nanmean(np.square(one.spreads))))


def _build_experiment(
    table: ConditionTable,
    log: Log,
    scenario: Scenario,
    rows: Sequence[_Row],
    name: str,
    groups: dict[str, str],
    step: float | None,
) -> ConditionExperiment:
    scenarios = [_set_inputs(scenario, table.inputs, row.places[0]) for row in rows]
    system = scenarios[0].system
    measures, measured = _list_measures(table, rows)
    columns = {"time": [float(k + 1) for k in range(len(rows))]}
    columns |= {one.heading: measured[one.words] for one in measures}
    units = {"time": "s"} | {one.heading: one.unit for one in measures}
    factors = {one.words: tuple(math.sqrt(row.counts[one.words]) for row in rows) for one in measures}
    longest = scenario.step if step is None else step
    longest = _choose_step(scenarios) if longest is None else longest
    return ConditionExperiment(
        name,
        system,
        scenarios[0].waveform,
        Record(name, columns, units, table.path),
        {one.words: one.heading for one in measures},
        longest,
        weights=dict.fromkeys((one.words for one in measures), log.weight),
        groups={**log.groups, **groups},
        conditions=tuple(_list_conditions(table, rows, scenarios)),
        factors=factors,
        input_units={one.path: one.unit for one in table.inputs},
        level=next((one.path for one in table.inputs if one.level), ""),
    )


def _list_measures(table: ConditionTable, rows: Sequence[_Row]) -> tuple[list[MeasureColumn], dict[str, list[float]]]:
    """Return the measures present in at least one row, and the values of all measures."""
    measured = {one.words: [row.values[one.words] for row in rows] for one in table.measures}
    return [one for one in table.measures if np.isfinite(measured[one.words]).any()], measured


def _list_conditions(table: ConditionTable, rows: Sequence[_Row], scenarios: Sequence[Scenario]) -> Iterator[TableRow]:
    """Yield the condition of every row: its inputs, and the values that differ from the first row."""
    system = scenarios[0].system
    base = {leaf.path: float(leaf.value) for leaf in system.leaves()}
    for row, one in zip(rows, scenarios, strict=True):
        if compile_march(one.system) is not compile_march(system):
            raise InputError(f"Rows of `{table.path.name}` make systems of another kind; fit them one by one.")
        changes = {leaf.path: float(leaf.value) for leaf in one.system.leaves() if leaf.value != base[leaf.path]}
        inputs = {column.path: column.values[row.places[0]] for column in table.inputs}
        yield TableRow(inputs, changes, one.waveform, one.duration, table.numbers[row.places[0]])


def _set_inputs(scenario: Scenario, inputs: Sequence[InputColumn], k: int) -> Scenario:
    settings = {one.path: f"{one.values[k]!r} {one.unit}" if one.unit != "1" else one.values[k] for one in inputs}
    return read_scenario(scenario.text, scenario.path, settings)


def _choose_step(scenarios: Sequence[Scenario]) -> float:
    """Return the shortest step [s] that a sample of the rows needs for the tolerance."""
    places = sorted({round(k) for k in np.linspace(0, len(scenarios) - 1, TRIED)})
    tried = [scenarios[k] for k in places]
    return min(find_step(one.system, one.waveform, one.duration, one.tolerance, LEAST_STEPS + 1).step for one in tried)


# ---------------------------------------------------------------- noise, and held-out rows


def _choose_scales(
    experiments: Sequence[ConditionExperiment], noise: Mapping[str, list[tuple[float, int]]]
) -> tuple[dict[str, float], list[str]]:
    """Return the noise of single runs by measure, if repeats determine it."""
    scales, notes = dict[str, float](), list[str]()
    for words in dict.fromkeys(words for one in experiments for words in one.columns):
        values = np.concatenate(
            [one.measured[:, one.outputs.index(words)] for one in experiments if words in one.columns]
        )
        if np.nanmin(values) == np.nanmax(values):
            raise DataError(f"`{words}` is the same in all rows; nothing can be learned from it. Head it `-`.")
    for words, parts in noise.items():
        spare = sum(n for _, n in parts)
        size = math.sqrt(sum(square for square, _ in parts) / spare)
        if spare >= SPARE and size > 0.0:
            unit = next(e.describe_outputs()[words].unit for e in experiments if words in e.columns)
            scales[words] = size
            notes.append(
                f"Repeats of `{words}` scatter by {format_change(size, unit, 2)}, which is taken as its noise."
            )
    return scales, notes


def _choose_held_rows(
    experiments: Sequence[ConditionExperiment], hold_out: str | Sequence[str]
) -> tuple[list[ConditionExperiment], bool]:
    """Return the experiments with held-out rows, and whether each is left out in turn."""
    names = [one.name for one in experiments]
    if hold_out == EACH or (hold_out == AUTO and len(experiments) >= SPECIMENS):
        choose_held_out(EACH, names, [])
        return list(experiments), True
    if hold_out == AUTO:
        return hold_later(experiments) or _hold_share(experiments, LEFT_OUT), False
    if isinstance(hold_out, str) and hold_out.strip().endswith("%"):
        return _hold_share(experiments, read_share(hold_out)), False
    if hold_out == NONE:
        return list(experiments), False
    held_out_stretches = choose_held_out(hold_out, names, [one.record.times.tolist() for one in experiments])
    return [
        replace(one, held_out_intervals=ALL if rows else ())
        for one, rows in zip(experiments, held_out_stretches, strict=True)
    ], False


def _hold_share(experiments: Sequence[ConditionExperiment], share: float) -> list[ConditionExperiment]:
    """Return the experiments with a fraction of their conditions held out."""
    return [
        replace(one, held_out_intervals=tuple((k, k) for k in pick_rows(len(one.record), share))) for one in experiments
    ]


def hold_later(experiments: Sequence[object], share: float = LATER) -> list[ConditionExperiment] | None:
    """Return tables of cycles with the later cycles held out; None if one of them has no cycles."""
    tables = list[ConditionExperiment]()
    for one in experiments:
        if not isinstance(one, ConditionExperiment):
            return None
        levels = sorted(set(one.cycles))
        if len(levels) < 2:
            return None
        first = levels[-min(max(1, round(share * len(levels))), len(levels) - 1)]
        rows = [k + 1.0 for k, cycles in enumerate(one.cycles) if cycles >= first]
        tables.append(replace(one, held_out_intervals=tuple((k, k) for k in rows)))
    return tables


def pick_rows(count: int, share: float) -> list[float]:
    """Return the held-out rows for counts from 1 to `count`: the last, the middle, the first, then halves between."""
    wanted = min(max(1, round(share * count)), count - 1)
    if wanted < 1:
        return []
    rows, depth = [count, 1 + count // 2, 1], 2
    while len(dict.fromkeys(rows)) < wanted:
        rows += [1 + round((count - 1) * (2 * k + 1) / 2**depth) for k in range(2 ** (depth - 1))]
        depth += 1
    return sorted(float(k) for k in list(dict.fromkeys(rows))[:wanted])
