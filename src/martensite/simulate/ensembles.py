"""Ensembles: many runs of one system to a tolerance, with a bound on the error of each.

Every run is made at least twice, and its error is bounded, as in `martensite.simulate.accuracy`.
In C runs march in lanes (`martensite.simulate.marching_native`); without a compiler one after
another.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base.status import Status
from martensite.simulate.accuracy import (
    FINER,
    FLOOR,
    LEAST,
    LOCAL,
    MOST,
    SURE,
    choose_samples,
    march_to,
)
from martensite.simulate.adaptive import AdaptiveMarch
from martensite.simulate.compiled import CompiledMarch
from martensite.simulate.envelope import envelope_of, rows_inside
from martensite.simulate.marching import Marched, MarchPlan
from martensite.simulate.marching_native import RANGES, MarchRows, Runs, march_runs

Numbers: TypeAlias = NDArray[np.float64]
RIPPLE, RESIDUAL = 7, 8


@dataclass(frozen=True, eq=False)
class Ensemble:
    """What runs did."""

    outputs: Numbers
    """(runs, samples, outputs), in SI; NaN after the end of a run that stopped."""
    status: NDArray[np.int8]
    """(runs,)"""
    ended: Numbers
    """Time [s] at which each ended, (runs,)."""
    accuracy: Numbers
    """How far what is judged may be off, as a share of its range, (runs,); NaN of a run that failed
    otherwise than by leaving the envelope."""

    @staticmethod
    def empty(runs: int, samples: int, outputs: int, status: Status) -> Ensemble:
        """Runs of which nothing is known but a status."""
        rows = np.full((runs, samples, outputs), np.nan)
        nothing = np.full(runs, np.nan)
        return Ensemble(rows, np.full(runs, status, np.int8), nothing, nothing.copy())


def march_in_lanes(runs: Runs, tolerance: float) -> Ensemble:
    """Make runs in C, each to a tolerance.

    Args:
        runs: the runs; the tolerance of their plan does not count.
        tolerance: what accuracy is wanted, as a share of ranges.
    """
    plan, compiled = runs.plan, runs.plan.compiled
    judged = [compiled.outputs.index(name) for name, _ in compiled.convergence_scales]
    outputs = tuple(dict.fromkeys((*runs.outputs, *judged)))
    seen = [outputs.index(place) for place in judged]
    compared, local = choose_samples(len(plan.times)), LOCAL[plan.order] * tolerance
    some = replace(plan, times=[plan.times[k] for k in compared], tolerance=local)
    whole = replace(runs, outputs=outputs)
    before = march_runs(replace(whole, plan=some))
    rows, numbers = before.outputs, before.numbers
    found = Ensemble.empty(runs.count, len(plan.times), len(runs.outputs), Status.OK)
    left = np.arange(runs.count)
    for _ in range(MOST):
        local /= FINER
        finer = replace(whole, plan=replace(plan, tolerance=local, parted=True))
        made = march_runs(finer.choose(left, numbers[:, RANGES:]))
        now = made.outputs[:, compared]
        apart = np.abs(rows[:, :, seen] - now[:, :, seen])
        accuracy = np.maximum(_bound_errors(compiled, apart, made), FLOOR * tolerance)
        _place_runs(found, made, left, accuracy)
        rest = accuracy > tolerance
        left, rows, numbers = left[rest], now[rest], made.numbers[rest]
        if not len(left):
            break
    return found


def _bound_errors(compiled: CompiledMarch, apart: Numbers, made: MarchRows) -> Numbers:
    """How far runs may be off, from what two of each differ by, (runs, samples, judged)."""
    least = np.array([least for _, least in compiled.convergence_scales])
    scales = np.maximum(made.numbers[:, RANGES:], least)
    known = np.isfinite(apart)
    worst = (np.where(known, apart, 0.0).max(axis=1) / scales).max(axis=1, initial=0.0)
    heat = scales[:, 0] if len(least) else 1.0
    total = np.maximum(SURE * worst + made.numbers[:, RIPPLE] / heat, made.numbers[:, RESIDUAL])
    sure = np.isfinite(total) & known[:, 0].all(axis=-1)
    return np.where(sure, np.maximum(total, LEAST), np.inf)


def _place_runs(found: Ensemble, made: MarchRows, places: Any, accuracy: Numbers) -> None:
    """Put runs to their places."""
    outputs = made.outputs[:, :, : found.outputs.shape[2]]
    status = made.numbers[:, 0].astype(np.int8)
    lost = (status < Status.UNSOLVED) & ~np.isfinite(outputs).all(axis=(1, 2))
    status[lost] = Status.NOT_FINITE
    found.outputs[places], found.status[places] = outputs, status
    found.ended[places] = made.numbers[:, 1]
    failed = (status >= Status.UNSOLVED) & (status != Status.OUT_OF_ENVELOPE)
    found.accuracy[places] = np.where(failed, np.nan, accuracy)


def march_one_by_one(
    plan: MarchPlan,
    systems: Iterable[tuple[AbstractSystem, Sequence[Any]]],
    count: int,
    outputs: Sequence[int],
    tolerance: float,
) -> Ensemble:
    """Make runs on plain floats, each to a tolerance.

    Args:
        plan: what they have in common.
        systems: the system and the waveforms of every run.
        count: number of runs.
        outputs: places of the outputs that are kept.
        tolerance: what accuracy is wanted, as a share of ranges.
    """
    found = Ensemble.empty(count, len(plan.times), len(outputs), Status.NOT_FINITE)
    found.ended[:] = 0.0
    for run, (system, waveforms) in enumerate(systems):
        own = replace(plan, waveforms=waveforms, limits=envelope_of(system))
        try:
            functions = plan.compiled.program.bind_floats(*plan.compiled.values(system))
            one, accuracy = march_to(
                lambda p, f=functions: AdaptiveMarch(p, f).run(), own, tolerance
            )
        except ArithmeticError:  # what follows from parameters alone is no number
            continue
        _keep_one(found, run, system, one, accuracy, outputs)
    return found


def _keep_one(
    found: Ensemble,
    run: int,
    system: AbstractSystem,
    one: Marched,
    accuracy: float,
    outputs: Sequence[int],
) -> None:
    """Put a run to its place."""
    rows = list(rows_inside(system, one.rows))
    found.outputs[run, : len(rows)] = np.asarray(rows)[:, list(outputs)]
    found.status[run], found.ended[run] = one.status, one.time
    inside = one.status is Status.OUT_OF_ENVELOPE or not one.status.failed
    found.accuracy[run] = accuracy if inside else np.nan
