"""Isobaric records, split into cycles of one heating and one cooling under constant stress.

A leg extends from one extreme of the temperature to the next and spans at least `FULL` of the range, so that noise,
holds and small reversals are ignored. Two consecutive legs form a cycle, from cold or from hot. Cycles are counted from
the first full leg. Earlier rows, and half a cycle at the end, are not used.

Rows are in the order of time. Strain is positive in elongation and thus falls on heating under tension.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from martensite.base.errors import DataError, ParameterError
from martensite.characterise.loop_paths import FULL, LoopPath, find_turns, trace_loop
from martensite.signals.records import Record, not_finite, out_of_order

FEWEST_ROWS = 20
"""Least number of rows of a record."""
FEWEST_IN_BRANCH = 8
"""Least number of rows of a branch."""
LEAST_RANGE = 5.0
"""Least temperature range of heating [K]."""
COLDEST, HOTTEST = 150.0, 1500.0
"""Limits of a plausible temperature [K]."""
LARGEST_STRAIN = 0.5
NOISY = 0.5
"""Scatter of the temperature from row to row above which it is smoothed [K]."""
SMALLEST_STRESS, LARGEST_STRESS = 1e4, 5e9
"""Limits of a plausible nonzero stress [Pa]."""
STEADY = 0.2
"""Standard deviation of a stress, as a fraction of its mean, above which a remark is made."""
WANDERING = 10e6
"""Absolute variation of the stress above which a remark is made, if `STEADY` is also exceeded [Pa]."""

NAMED_STRESS = re.compile(r"(\d+(?:\.\d+)?)[ _]?MPa", re.IGNORECASE)
"""Stress in the name of a record."""


@dataclass(frozen=True)
class CycleBranch:
    """Rows of one heating or one cooling, in their order."""

    temperature: tuple[float, ...]
    """[K]"""
    strain: tuple[float, ...]
    """[-]"""


@dataclass(frozen=True)
class IsobaricCycle:
    """Heating and cooling under one stress."""

    name: str
    """Name of the record."""
    stress: float
    """Mean stress over the cycle, or the given stress [Pa]."""
    stress_deviation: float
    """Standard deviation of the stress over the cycle [Pa]; 0 for a given stress."""
    heating: CycleBranch
    cooling: CycleBranch
    cold_start: bool
    """True if heating comes first."""
    timed: bool
    """True if the rows have recorded times, which confirm their order."""
    number: int
    """Number of the cycle in the record, from 1."""
    cycles: int
    """Number of cycles in the record."""
    remarks: tuple[str, ...] = ()
    """Remarks for the user, in sentences."""


def cut_cycle(record: Record, *, stress: float | None = None, cycle: int = -1) -> IsobaricCycle:
    """Cut one cycle out of a record and split it into heating and cooling.

    Args:
        record: columns `temperature` [K], `strain` [-] and optionally `stress` [Pa].
        stress: constant stress [Pa], by default the mean of the column over the cycle.
        cycle: index of the cycle, by default the last.

    Raises:
        DataError: a column is missing, too short or contradicts its name, or there is no full cycle.
        ParameterError: the cycle does not exist, or the stress is not finite.
    """
    rows = _rows_in_time(record)
    kelvin, strain = (record[name][rows].tolist() for name in ("temperature", "strain"))
    _check_columns(record.name, kelvin, strain)
    path = trace_loop(kelvin)
    if path.scatter > NOISY:
        kelvin = path.drive.tolist()
    legs = list(pairwise(find_turning_points(kelvin)))
    cycles = len(legs) // 2
    if not cycles:
        raise DataError(_no_cycle(record.name, kelvin, len(legs)))
    if not -cycles <= cycle < cycles:
        raise ParameterError(
            f"Argument `cycle` must be from {-cycles} to {cycles - 1}, since record "
            f"`{record.name}` has {cycles} full cycle{'s' * (cycles > 1)}, but is {cycle}."
        )
    number = cycle % cycles
    pair = legs[2 * number : 2 * number + 2]
    branches = [_cut_branch(record.name, kelvin[a : b + 1], strain[a : b + 1]) for a, b in pair]
    cold_start = kelvin[pair[0][0]] < kelvin[pair[0][1]]
    level, deviation = _mean_stress(record, rows[pair[0][0] : pair[1][1] + 1], stress)
    return IsobaricCycle(
        record.name,
        level,
        deviation,
        heating=branches[0 if cold_start else 1],
        cooling=branches[1 if cold_start else 0],
        cold_start=cold_start,
        timed=record.interval is None,
        number=number + 1,
        cycles=cycles,
        remarks=(*_list_remarks(level, deviation, number + 1, cycles), *_describe_jitter(path)),
    )


def find_named_stress(record: Record) -> float | None:
    """Return the stress in the name of a record, as in `wire_100MPa` [Pa]; None without one."""
    named = NAMED_STRESS.search(record.name)
    return 1e6 * float(named[1]) if named else None


def find_turning_points(temperatures: Sequence[float]) -> list[int]:
    """Return the rows at which the temperature [K] turns, including both ends of all full legs."""
    span = max(temperatures) - min(temperatures)
    if span < LEAST_RANGE:
        return []
    return find_turns(temperatures, FULL * span)


def _rows_in_time(record: Record) -> list[int]:
    """Return the indices of the rows in the order of their times."""
    if out_of_order(record.times) is None:
        return list(range(len(record)))
    return record.times.argsort(kind="stable").tolist()


def _cut_branch(name: str, kelvin: list[float], strain: list[float]) -> CycleBranch:
    if len(kelvin) < FEWEST_IN_BRANCH:
        way = "heating" if kelvin[-1] > kelvin[0] else "cooling"
        raise DataError(
            f"Record `{name}` has only {len(kelvin)} rows on {way}, but a branch needs at least "
            f"{FEWEST_IN_BRANCH}; sample more often."
        )
    return CycleBranch(tuple(kelvin), tuple(strain))


def _mean_stress(record: Record, rows: list[int], given: float | None) -> tuple[float, float]:
    """Return the stress and its standard deviation [Pa]."""
    if given is not None:
        if not math.isfinite(given):
            raise ParameterError(f"Argument `stress` must be finite, but is {given} Pa.")
        return given, 0.0
    if "stress" not in record.columns:
        named = find_named_stress(record)
        if named is not None:
            return named, 0.0
        raise DataError(
            f"Record `{record.name}` has no column `stress`: give the constant stress of the cycle (`--stress`), or "
            "write it in the name of the file (`wire_100MPa.csv`)."
        )
    values = record["stress"][rows].tolist()
    _check_finite(record.name, "stress", values)
    mean = math.fsum(values) / len(values)
    deviation = math.sqrt(math.fsum((s - mean) ** 2 for s in values) / len(values))
    small = 0.0 < abs(mean) < SMALLEST_STRESS and deviation < SMALLEST_STRESS
    if small or abs(mean) > LARGEST_STRESS:
        raise DataError(
            f"The stress of record `{record.name}` is {mean:.4g} Pa on average; is its unit off, "
            "or are columns swapped?"
        )
    return mean, deviation


# ---------------------------------------------------------------- error texts


def _check_columns(name: str, kelvin: Sequence[float], strain: Sequence[float]) -> None:
    """Raise `DataError` unless the columns can be a temperature [K] and a strain [-]."""
    if len(kelvin) < FEWEST_ROWS:
        raise DataError(
            f"Record `{name}` has {len(kelvin)} rows, but a heating-cooling cycle needs at least {FEWEST_ROWS}."
        )
    _check_finite(name, "temperature", kelvin)
    _check_finite(name, "strain", strain)
    low, high = min(kelvin), max(kelvin)
    if low < COLDEST or high > HOTTEST:
        raise DataError(
            f"The temperature of record `{name}` goes from {low:.4g} to {high:.4g} K, but must "
            f"stay between {COLDEST:g} and {HOTTEST:g} K; is its unit off (degC, or by 10^3), or "
            "are columns swapped?"
        )
    largest = max(map(abs, strain))
    if largest > LARGEST_STRAIN:
        raise DataError(
            f"The strain of record `{name}` reaches {largest:.4g}, but must stay within "
            f"{LARGEST_STRAIN:g}; is its unit off (percent, or by 10^3), or are columns swapped?"
        )


def _check_finite(name: str, column: str, values: Any) -> None:
    row = not_finite(values)
    if row is not None:
        raise DataError(f"Column `{column}` of record `{name}` must be finite, but holds a gap.")


def _no_cycle(name: str, kelvin: Sequence[float], legs: int) -> str:
    if not legs:
        return (
            f"Record `{name}` holds no full cycle: its temperature stays between {min(kelvin):.4g} "
            f"and {max(kelvin):.4g} K."
        )
    way = "rises" if kelvin[-1] > kelvin[0] else "falls"
    return (
        f"Record `{name}` holds no full cycle: its temperature only {way}, from {kelvin[0]:.4g} "
        f"to {kelvin[-1]:.4g} K; record heating and cooling, each over at least "
        f"{100 * FULL:g} % of the range."
    )


def _describe_jitter(path: LoopPath) -> list[str]:
    """Return a remark on a temperature that was smoothed."""
    if path.scatter <= NOISY:
        return []
    return [
        f"The temperature scatters by {path.scatter:.2g} K from row to row. It is smoothed over at least {path.window} "
        f"rows, so that each temperature is uncertain by about {2.0 * path.error:.2g} K."
    ]


def _list_remarks(stress: float, deviation: float, number: int, cycles: int) -> tuple[str, ...]:
    remarks: list[str] = []
    if cycles > 1:
        remarks.append(f"Cycle {number} of {cycles} is used.")
    if deviation > WANDERING and deviation > STEADY * abs(stress):
        remarks.append(
            f"The stress of {stress / 1e6:.4g} MPa varies by {deviation / 1e6:.2g} MPa (standard "
            "deviation): is the cycle isobaric?"
        )
    return tuple(remarks)
