"""Columns whose headings were swapped: what a fit finds with two of them exchanged.

Only where a fit follows what is compared worse than a constant would. Then the numbers of every
pair of a column that drives and one that is compared are exchanged, as they probably stand in the
file, and the record is fitted once more by itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from martensite.base import units
from martensite.base.errors import DataError, MartensiteError
from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit
from martensite.fit.problem import Problem
from martensite.fit.solve import solve_problem
from martensite.scenario.scenario import Scenario
from martensite.signals.records import Record

CONVINCING_FIT = 50.0
"""Fit [%] with exchanged columns from which on they look swapped."""
MOST_EVALUATIONS = 30
"""Evaluations of such a fit."""
SPELLINGS = {"1": ("1", "%"), "m": ("mm", "m"), "Pa": ("MPa", "Pa"), "K": ("degC", "K")}
"""SI unit -> units in which such a column is usually written; others as they are."""

Model = Callable[[Record], Scenario]


def refuse_swapped(fit: Fit, models: dict[str, tuple[Scenario, Model]]) -> None:
    """Raise `DataError` if a record makes far more sense with two columns exchanged.

    Args:
        fit: to the records as given.
        models: record -> its scenario, and what makes it with another record.
    """
    useless = {(s.record, s.output): s for s in fit.scores if s.part == "training"}
    for one in fit.problem.experiments:
        scenario, model = models[one.name]
        for output, column in one.columns.items():
            if not useless[one.name, output].fit_percent < 0.0:
                continue
            for drive in dict.fromkeys(scenario.follows.values()):
                for record in _exchange_columns(one.record, drive, column):
                    found = _fit_exchanged(fit.problem, one, record, model, output)
                    if found > CONVINCING_FIT:
                        raise DataError(_describe_swap(one, output, drive, column, found))


def _describe_swap(one: Experiment, output: str, drive: str, column: str, found: float) -> str:
    return (
        f"Record `{one.record.name}` makes far more sense with its columns `{drive}` and "
        f"`{column}` exchanged: as they are, the best fit follows `{output}` worse than a constant "
        f"would; exchanged, to {found:.0f} %. Their headings seem to be swapped."
    )


def _fit_exchanged(problem: Problem, one: Experiment, record: Record, model: Model, output: str) -> float:
    """How well an output is met with another record; -inf where that cannot be fitted."""
    try:
        scenario = model(record)
        twin = replace(one, system=scenario.system, waveform=scenario.waveform, record=record)
        free = tuple(free for free in problem.free if free.record in (None, one.name))
        alone = replace(problem, experiments=(twin,), free=free, later=())
        scores = solve_problem(alone, most=MOST_EVALUATIONS).scores
    except MartensiteError:
        return float("-inf")
    return min(s.fit_percent for s in scores if s.output == output and s.part == "training")


def _exchange_columns(record: Record, one: str, other: str) -> Iterator[Record]:
    """The record with the cells of two columns exchanged, in the units they may be written in."""
    for first in SPELLINGS.get(record.units[one], (record.units[one],)):
        for second in SPELLINGS.get(record.units[other], (record.units[other],)):
            columns = record.columns | {
                one: _convert_column(record, other, second, one, first),
                other: _convert_column(record, one, first, other, second),
            }
            yield replace(record, columns=columns)


def _convert_column(record: Record, column: str, spelling: str, to: str, new: str) -> list[float]:
    """The numbers of a column in one unit, read as those of another column in another unit."""
    factor, offset = units.find_conversion(spelling, record.units[column])
    new_factor, new_offset = units.find_conversion(new, record.units[to])
    return [(x - offset) / factor * new_factor + new_offset for x in record[column]]
