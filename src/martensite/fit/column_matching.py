"""Assignment of log columns to compared outputs and to drives.

By default every column that is an output of the system is compared, except drives and constant columns. Explicit
texts such as `position=laser*0.5` mean that output `position` is half the column `laser`.

A second check finds swapped headings. If a fit predicts an output worse than a constant, each pair of a drive and a
compared column is exchanged, and the record is fitted again.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.mechanisms.base import Output
from martensite.base import units
from martensite.base.errors import (
    DataError,
    InputError,
    MartensiteError,
    ParameterError,
    UnitError,
    require_known,
    suggest_name,
)
from martensite.fit.experiment import Experiment
from martensite.fit.fit import Fit
from martensite.fit.free_parameters import split_list
from martensite.fit.problem import Problem
from martensite.fit.solve import solve_problem
from martensite.scenario.exact_text import shown_range
from martensite.scenario.scenario import Scenario
from martensite.search.free_numbers import read_difference
from martensite.signals.records import Record

CONVINCING_FIT = 50.0
"""Fit [%] with exchanged columns above which they look swapped."""
MOST_EVALUATIONS = 30
"""Largest number of evaluations of such a fit."""
SPELLINGS = {"1": ("1", "%"), "m": ("mm", "m"), "Pa": ("MPa", "Pa"), "K": ("degC", "K")}
"""SI unit -> usual units of such a column; other units stay as they are."""

Model = Callable[[Record], Scenario]
_COLUMN = re.compile(r"^\s*([^=*]+?)\s*(?:=\s*([^*]+?)\s*(?:\*\s*(.+?)\s*)?)?$")
ECHOES = {"K": ("temperature", "hottest"), "V": ("voltage",), "A": ("current",), "W": ("power",)}
"""Unit of a drive -> outputs that only repeat the drive."""


@dataclass(frozen=True)
class ComparedColumn:
    """Output compared with a column."""

    output: str
    column: str
    factor: float = 1.0
    """Factor from the column in SI to the output in SI."""


def list_echoes(system: AbstractSystem) -> set[str]:
    """Return the outputs that repeat a drive of a system."""
    echoes = set(system.signals())
    for port, one in system.actuators().items():
        names = ("drive", *ECHOES.get(one.source.unit, ()))
        echoes |= {system.label(port, name) for name in names}
    return echoes


def match_columns(
    record: Record, system: AbstractSystem, wanted: Sequence[ComparedColumn], follows: Mapping[str, str]
) -> tuple[dict[str, str], Record, list[str]]:
    """Return output -> column of a record, the record with scaled columns, and the left-out columns.

    Args:
        record: measured record.
        system: system that models the record.
        wanted: requested outputs, empty for all common outputs.
        follows: drive -> followed column.

    Raises:
        DataError: a column is missing, or no column can be compared.
    """
    if wanted:
        return _match_asked(record, wanted, system)
    driven = list_echoes(system) | set(follows.values())
    common = [n for n in record.columns if n in system.outputs() and n not in driven]
    if not common:
        raise DataError(_refuse_nothing(record, system, driven))
    varied = [name for name in common if not _is_constant(record[name])]
    notes: list[str] = []
    for name in common if varied else ():
        if name in varied:
            continue
        why = "never changes" if any(map(math.isfinite, record[name])) else "holds no numbers"
        notes.append(f"Column `{name}` of record `{record.name}` {why} and is not compared.")
    return {name: name for name in varied or common}, record, notes


def _match_asked(
    record: Record, wanted: Sequence[ComparedColumn], system: AbstractSystem
) -> tuple[dict[str, str], Record, list[str]]:
    columns, outputs, notes = {}, system.outputs(), list[str]()
    for one in wanted:
        column = _find_column(record, one.column)
        columns[one.output] = column
        if one.factor != 1.0 and one.output in outputs:
            notes.append(_describe_scaling(record, column, one, outputs[one.output].unit))
            record = _scale_column(record, column, one, outputs[one.output].unit)
            columns[one.output] = one.output
    return columns, record, notes


def _describe_scaling(record: Record, column: str, one: ComparedColumn, unit: str) -> str:
    """Describe the effect of the factor of a column, which acts on SI values."""
    finite = [x for x in record[column].tolist() if math.isfinite(x)]
    if not finite:
        return f"Column `{column}` of record `{record.name}` holds no numbers."
    before = shown_range((min(finite), max(finite)), record.units[column])
    low, high = sorted((one.factor * min(finite), one.factor * max(finite)))
    si = "" if record.units[column] == "1" else f" {record.units[column]}"
    return (
        f"Column `{column}` of record `{record.name}`, {before}, is taken in{si or ' plain numbers'} times "
        f"{one.factor:g} as `{one.output}`: {shown_range((low, high), unit)}."
    )


def _find_column(record: Record, name: str) -> str:
    spelt = re.sub(r"[\s-]+", "_", name.strip().lower())
    if name not in record.columns and spelt not in record.columns:
        columns = [column for column in record.columns if column != "time"]
        raise DataError(f"Record `{record.name}` has no column `{name}`. {suggest_name(name, columns)}")
    return name if name in record.columns else spelt


def _scale_column(record: Record, column: str, one: ComparedColumn, unit: str) -> Record:
    numbers = one.factor * record[column]
    return replace(record, columns=record.columns | {one.output: numbers}, units=record.units | {one.output: unit})


def _is_constant(numbers: Any) -> bool:
    finite_numbers = numbers[np.isfinite(numbers)]
    return not finite_numbers.size or bool(finite_numbers.max() == finite_numbers.min())


def _refuse_nothing(record: Record, system: AbstractSystem, driven: set[str]) -> str:
    columns = [name for name in record.columns if name != "time"]
    listed = ", ".join(f"`{name}`" for name in columns) or "none but `time`"
    drives = ", ".join(f"`{name}`" for name in columns if name in driven)
    why = f", of which {drives} say what drives" if drives else ""
    return (
        f"Record `{record.name}` has no column to compare: it holds {listed}{why}; the system "
        f"gives {', '.join(f'`{n}`' for n in system.outputs() if n not in driven)}. For a column "
        "of another name write `OUTPUT=COLUMN` (--column)."
    )


def read_noise(
    noise: Mapping[str, str | float], all_outputs: Mapping[str, Output], followed: Mapping[str, str]
) -> tuple[dict[str, float], dict[str, float]]:
    """Return the standard deviations of outputs and drive columns in SI; plain numbers are in SI already.

    Args:
        noise: name -> amount.
        all_outputs: outputs.
        followed: drive column -> its SI unit.

    Raises:
        InputError: a name is unknown, or an amount is not above 0.
    """
    outputs = {name: one.unit for name, one in all_outputs.items()}
    amounts: dict[str, float] = {}
    for name, given in noise.items():
        require_known("output", name, outputs | dict(followed))
        unit = followed.get(name) or outputs[name]
        try:
            amount = float(given)
        except ValueError:
            amount = _read_noise(str(given), name, unit)
        if not amount > 0.0:
            raise ParameterError(f"The noise of `{name}` must be above 0, but is {given}.")
        amounts[name] = amount
    return {n: x for n, x in amounts.items() if n not in followed}, {n: x for n, x in amounts.items() if n in followed}


def _read_noise(text: str, name: str, unit: str) -> float:
    try:
        return read_difference(text, unit)
    except UnitError as error:
        raise UnitError(f"Noise of `{name}`: {error}") from None


def read_columns(columns: str | Sequence[str] | Mapping[str, str] | None) -> list[ComparedColumn]:
    """Return the outputs and their columns; empty columns if the texts contain no names.

    Raises:
        InputError: an entry cannot be read.
    """
    if columns is None:
        return []
    if isinstance(columns, Mapping):
        columns = [f"{output}={column}" for output, column in columns.items()]
    compared_columns = [_read_column(text) for text in split_list(columns)]
    names = [one.output for one in compared_columns]
    double = next((name for name in names if names.count(name) > 1), None)
    if double is not None:
        raise InputError(f"Output `{double}` is compared with two columns; name one.")
    return compared_columns


def _read_column(text: str) -> ComparedColumn:
    match = _COLUMN.match(text)
    if match is not None:
        try:
            return ComparedColumn(match[1], match[2] or match[1], float(match[3] or 1.0))
        except ValueError:
            pass
    raise ParameterError(
        f"`{text}` is not a column to compare; write `OUTPUT`, `OUTPUT=COLUMN`, or `OUTPUT=COLUMN*FACTOR`."
    )


def refuse_swapped(fit: Fit, models: dict[str, tuple[Scenario, Model]]) -> None:
    """Raise `DataError` if a record fits far better with two columns exchanged.

    Args:
        fit: fit to the records as given.
        models: record -> its scenario, and a function that builds it with another record.
    """
    useless = {(s.record, s.output): s for s in fit.scores if s.part == "training"}
    for one in fit.problem.experiments:
        scenario, model = models[one.name]
        for output, column in one.columns.items():
            if not useless[one.name, output].fit_percent < 0.0:
                continue
            for drive in dict.fromkeys(scenario.follows.values()):
                for record in _exchange_columns(one.record, drive, column):
                    percent = _fit_exchanged(fit.problem, one, record, model, output)
                    if percent > CONVINCING_FIT:
                        raise DataError(_describe_swap(one, output, drive, column, percent))


def _describe_swap(one: Experiment, output: str, drive: str, column: str, percent: float) -> str:
    return (
        f"Record `{one.record.name}` makes far more sense with its columns `{drive}` and "
        f"`{column}` exchanged: as they are, the best fit follows `{output}` worse than a constant "
        f"would; exchanged, to {percent:.0f} %. Their headings seem to be swapped."
    )


def _fit_exchanged(problem: Problem, one: Experiment, record: Record, model: Model, output: str) -> float:
    """Return the fit of an output with another record; -inf if the fit fails."""
    try:
        scenario = model(record)
        twin = replace(one, system=scenario.system, waveform=scenario.waveform, record=record)
        free = tuple(free for free in problem.free if free.record in (None, *one.labels))
        alone = replace(problem, experiments=(twin,), free=free, later=())
        scores = solve_problem(alone, most=MOST_EVALUATIONS).scores
    except MartensiteError:
        return float("-inf")
    return min(s.fit_percent for s in scores if s.output == output and s.part == "training")


def _exchange_columns(record: Record, one: str, other: str) -> Iterator[Record]:
    for first in SPELLINGS.get(record.units[one], (record.units[one],)):
        for second in SPELLINGS.get(record.units[other], (record.units[other],)):
            columns = record.columns | {
                one: _convert_column(record, other, second, one, first),
                other: _convert_column(record, one, first, other, second),
            }
            yield replace(record, columns=columns)


def _convert_column(record: Record, column: str, spelling: str, to: str, new: str) -> Any:
    """Return the values of a column in one unit, read as another column in another unit."""
    factor, offset = units.find_conversion(spelling, record.units[column])
    new_factor, new_offset = units.find_conversion(new, record.units[to])
    return (record[column] - offset) / factor * new_factor + new_offset
