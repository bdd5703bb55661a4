"""Variance-based sensitivity indices of the measures of a sweep.

The first order is the mean reduction of the variance for a known parameter, the total order the remaining variance if
all others are known; their difference is due to interactions. The estimate depends on the design:

    saltelli       Saltelli et al. (2010), Comput. Phys. Commun. 181, table 2 b and f, with bootstrap intervals
    whole grid     sums of squares over equally likely levels; no interval
    other samples  `martensite.design.sweep.given_data_indices`

Parameters are independent and have the distributions of the design.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError
from martensite.design.sweep.given_data_indices import NORMAL_95, SensitivityIndex, estimate_indices, is_spread
from martensite.design.sweep.sampling.samples import count_block_runs
from martensite.design.sweep.table import SweepColumn, SweepTable
from martensite.signals.sampling.sampled import Numbers

LEAST_BLOCKS = 8
LEAST_RUNS = 32
BOOTSTRAP = 20_000_000
"""Largest number of values drawn for the intervals."""
WIDE_INTERVAL = 0.1
"""Half an interval that gets a remark."""


@dataclass(frozen=True, eq=False)
class SensitivityIndices:
    """Sensitivity indices of a measure."""

    measure: str
    unit: str
    """SI unit of the measure."""
    method: str
    """saltelli, grid or given data."""
    names: tuple[str, ...]
    """Paths of the varied parameters."""
    indices: dict[str, SensitivityIndex]
    """Indices of all parameters by kind, such as `first` and `total`."""
    mean: float
    deviation: float
    used: int
    """Number of runs."""
    remarks: list[str] = field(default_factory=list[str])

    @property
    def order(self) -> list[int]:
        """Return the places of the parameters by importance: by total order, delta or first order."""
        leading = next(self.indices[k] for k in ("total", "delta", "first") if k in self.indices)
        return [int(k) for k in np.argsort(-np.nan_to_num(leading.values), kind="stable")]


def compute_sensitivity(table: SweepTable, measures: Sequence[str] | None = None) -> list[SensitivityIndices]:
    """Return the sensitivity indices of the measures of a sweep.

    Args:
        table: runs of the sweep.
        measures: names of measures, by default all.

    Raises:
        UnknownNameError: the measure does not exist.
        DataError: there are too few runs.
    """
    return [_analyse_measure(table, one) for one in table.choose_measures(None if measures is None else list(measures))]


def _analyse_measure(table: SweepTable, one: SweepColumn) -> SensitivityIndices:
    usable = table.good & np.isfinite(one.values)
    if table.design == "saltelli":
        return _analyse_blocks(table, one, usable)
    if table.shape is not None and usable.all():
        indices = estimate_grid_indices(one.values.reshape(table.shape))
        return _build_result(table, one, "grid", indices, one.values, [])
    remarks = _describe_left_out(table, one, usable)
    if table.shape is not None:
        remarks.append("The grid is not whole: its runs are taken as a sample.")
    least = max(LEAST_RUNS, 4 * len(table.varied))
    if usable.sum() < least:
        raise DataError(f"`{one.name}` is known of {usable.sum():,} runs; at least {least} are needed.")
    x, y = table.inputs[usable], one.values[usable]
    indices, more = estimate_indices(x, y)
    return _build_result(table, one, "given data", indices, y, remarks + more)


def _build_result(
    table: SweepTable, one: SweepColumn, method: str, indices: dict[str, SensitivityIndex], y: Numbers, more: list[str]
) -> SensitivityIndices:
    varies = is_spread(y)
    constant = [] if varies else ["It is the same in all runs: nothing to be explained."]
    return SensitivityIndices(
        one.name,
        one.unit,
        method,
        tuple(table.varied),
        indices,
        float(np.mean(y)),
        float(np.std(y)) if varies else 0.0,
        y.size,
        [*more, *constant],
    )


def _describe_left_out(table: SweepTable, one: SweepColumn, usable: NDArray[np.bool_]) -> list[str]:
    """Return sentences on runs without a value."""
    never = int(np.sum(table.good & ~usable))
    counts = (
        (table.missing, "not made yet"),
        (table.failed, "failed"),
        (never, f"without `{one.name}`, as it never happened in them"),
    )
    return [f"{count:,} runs are left out: {why}." for count, why in counts if count]


# ---------------------------------------------------------------- blocks


def _analyse_blocks(table: SweepTable, one: SweepColumn, usable: NDArray[np.bool_]) -> SensitivityIndices:
    """Return the indices of a design `saltelli`, without incomplete blocks."""
    size = count_block_runs(len(table.varied))
    whole = usable.reshape(-1, size).all(axis=1)
    remarks = _describe_left_out(table, one, usable)
    if not whole.all():
        count = int(np.sum(~whole))
        remarks.append(
            f"{count:,} of {whole.size:,} blocks are left out, as one of their runs is: the "
            "indices hold for what is left, and shift if those runs were alike."
        )
    if whole.sum() < LEAST_BLOCKS:
        raise DataError(
            f"`{one.name}` is known of {whole.sum()} whole blocks; at least {LEAST_BLOCKS} are "
            "needed. Ask for more, such as `--sample saltelli:1024`."
        )
    y = one.values.reshape(-1, size)[whole].ravel()
    indices = estimate_block_indices(y, len(table.varied))
    widest = max(float(np.nanmax(i.wide, initial=0.0)) for i in indices.values())
    if widest > WIDE_INTERVAL:
        remarks.append(f"Intervals reach ± {widest:.2g}: more base samples would narrow them.")
    return _build_result(table, one, "saltelli", indices, y, remarks)


def estimate_block_indices(y: Numbers, width: int) -> dict[str, SensitivityIndex]:
    """Return the first and total order from blocks of runs, with 95 % intervals.

    Args:
        y: a measure of all runs in the order of the design, (blocks (width + 2),).
        width: number of axes.
    """
    if not is_spread(y):
        return {name: SensitivityIndex.unknown(width) for name in ("first", "total")}
    blocks = y.reshape(-1, count_block_runs(width)) - np.mean(y)
    draws, rng = int(np.clip(BOOTSTRAP / y.size, 20, 200)), np.random.default_rng(0)
    rows = (rng.integers(len(blocks), size=len(blocks)) for _ in range(draws))
    wide = NORMAL_95 * np.std([_estimate_orders(blocks[block_numbers]) for block_numbers in rows], 0, ddof=1)
    pairs = zip(("first", "total"), _estimate_orders(blocks), wide, strict=True)
    return {name: SensitivityIndex(values, half) for name, values, half in pairs}


def _estimate_orders(blocks: Numbers) -> tuple[Numbers, Numbers]:
    """Return the first and total order from blocks with mean 0."""
    a, mixed, b = blocks[:, :1], blocks[:, 1:-1], blocks[:, -1:]
    variance = np.var(blocks[:, [0, -1]])
    first = np.mean(b * (mixed - a), axis=0) / variance
    return first, 0.5 * np.mean((a - mixed) ** 2, axis=0) / variance


# ---------------------------------------------------------------- grid


def estimate_grid_indices(y: Numbers) -> dict[str, SensitivityIndex]:
    """Return the first and total order on a grid with equally likely levels, from sums of squares.

    Args:
        y: a measure on the grid, one dimension per axis.
    """
    if not is_spread(y):
        return {name: SensitivityIndex.unknown(y.ndim) for name in ("first", "total")}
    every, variance = range(y.ndim), float(np.var(y))
    others = [tuple(j for j in every if j != k) for k in every]
    first = [float(np.var(np.mean(y, axis=axes))) / variance for axes in others]
    total = [1.0 - float(np.var(np.mean(y, axis=k))) / variance for k in every]
    none = np.full(y.ndim, np.nan)
    return {"first": SensitivityIndex(np.array(first), none), "total": SensitivityIndex(np.array(total), none)}
