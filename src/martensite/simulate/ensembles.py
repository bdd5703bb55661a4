"""Ensembles: many runs of one system to a tolerance, with a bound on the error of each.

Every run is made at least twice, and its error is bounded, as in `martensite.simulate.accuracy`.
In C runs march in lanes (`martensite.simulate.marching_native`); without a compiler one after
another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base.status import Status
from martensite.simulate.accuracy import FINER, FLOOR, LEAST, LOCAL, MOST, SURE, choose_samples, march_to
from martensite.simulate.adaptive import AdaptiveMarch
from martensite.simulate.compiled import CompiledMarch
from martensite.simulate.envelope import envelope_of, rows_inside
from martensite.simulate.march import COARSE, SOLVED
from martensite.simulate.marching import HAIR, MarchPlan
from martensite.simulate.marching_native import RANGES, MarchRows, Runs, march_runs

Numbers: TypeAlias = NDArray[np.float64]
Flags: TypeAlias = NDArray[np.bool_]
RIPPLE, RESIDUAL = 7, 8


@dataclass(frozen=True, eq=False)
class Ensemble:
    """What some runs of one system did."""

    columns: dict[str, Numbers]
    """One array (runs, samples) per output, in SI units; NaN for runs that were refused, and after
    the end of runs that stopped."""
    status: NDArray[np.int8]
    """Worst status of every run, (runs,)."""
    ended: Numbers
    """Time [s] at which every run ended, (runs,); NaN where that is not known."""
    accuracy: Numbers
    """How far what is judged may be off, as a share of its range, (runs,); NaN where nothing is
    estimated, or a run failed otherwise than by leaving the envelope."""

    @staticmethod
    def empty(names: Iterable[str], runs: int, samples: int, status: Status) -> Ensemble:
        """Runs of which nothing is known but a status."""
        columns = {name: np.full((runs, samples), np.nan) for name in names}
        nothing = np.full(runs, np.nan)
        return Ensemble(columns, np.full(runs, status, np.int8), nothing, nothing.copy())

    @staticmethod
    def on_steps(
        columns: dict[str, Numbers], reports: Numbers, left: Numbers, times: Sequence[float], solved: float = SOLVED
    ) -> Ensemble:
        """Runs on given steps: from their worst reports, and when they left the envelope [s].

        It is infinite for runs that stayed inside; what comes after it is struck out. A residual up to `solved`
        is none.
        """
        residual, crossing = reports[:2]
        verdicts = {Status.NOT_FINITE: ~np.isfinite(residual), Status.UNSOLVED: residual > solved}
        verdicts[Status.LONG_STEP] = crossing > COARSE
        status = np.select(list(verdicts.values()), list(verdicts), Status.OK).astype(np.int8)
        gone = (left < np.inf) & (status < Status.UNSOLVED)
        known = np.asarray(times) < np.where(gone, (1.0 - HAIR) * left, np.inf)[:, None]
        broken = [(~np.isfinite(column) & known).any(axis=1) for column in columns.values()]
        status[gone] = Status.OUT_OF_ENVELOPE
        status[np.logical_or.reduce(broken)] = Status.NOT_FINITE
        ended = np.where(status < Status.UNSOLVED, times[-1], np.where(gone, left, np.nan))
        kept = {name: np.where(known, column, np.nan) for name, column in columns.items()}
        return Ensemble(kept, status, ended, np.full(len(left), np.nan))

    def struck_out(self, bad: Flags) -> Ensemble:
        """With nothing of some runs but that they were refused."""
        columns = {name: np.where(bad[:, None], np.nan, c) for name, c in self.columns.items()}
        status = np.where(bad, np.int8(Status.REFUSED), self.status)
        return Ensemble(columns, status, np.where(bad, np.nan, self.ended), self.accuracy)

    def place_runs(self, places: Any, made: Ensemble) -> None:
        """Put other runs to their places."""
        for name, column in made.columns.items():
            self.columns[name][places] = column
        self.status[places], self.ended[places] = made.status, made.ended
        self.accuracy[places] = made.accuracy

    @staticmethod
    def concatenate(pieces: Sequence[Ensemble]) -> Ensemble:
        """Some after others."""
        names = pieces[0].columns
        columns = {name: np.concatenate([p.columns[name] for p in pieces]) for name in names}
        status, ended, accuracy = (
            np.concatenate([getattr(p, name) for p in pieces]) for name in ("status", "ended", "accuracy")
        )
        return Ensemble(columns, status, ended, accuracy)


def march_in_lanes(
    runs: Runs, names: Sequence[str], tolerance: float, march: Callable[[Runs], MarchRows] = march_runs
) -> Ensemble:
    """Make runs in C, each to a tolerance, as a share of ranges; that of their plan does not count."""
    plan, compiled = runs.plan, runs.plan.compiled
    judged = [compiled.outputs.index(name) for name, _ in compiled.convergence_scales]
    outputs = tuple(dict.fromkeys((*runs.outputs, *judged)))
    seen = [outputs.index(place) for place in judged]
    compared, local = choose_samples(len(plan.times)), LOCAL[plan.order] * tolerance
    some = replace(plan, times=[plan.times[k] for k in compared], tolerance=local)
    whole = replace(runs, outputs=outputs)
    before = march(replace(whole, plan=some))
    rows, numbers = before.outputs, before.numbers
    found = Ensemble.empty(names, runs.count, len(plan.times), Status.OK)
    left = np.arange(runs.count)
    for _ in range(MOST):
        local /= FINER
        finer = replace(whole, plan=replace(plan, tolerance=local, parted=True))
        made = march(finer.choose(left, numbers[:, RANGES:]))
        now = made.outputs[:, compared]
        apart = np.abs(rows[:, :, seen] - now[:, :, seen])
        accuracy = np.maximum(_bound_errors(compiled, apart, made), FLOOR * tolerance)
        found.place_runs(left, _judge_runs(made, names, accuracy))
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


def _judge_runs(made: MarchRows, names: Sequence[str], accuracy: Numbers) -> Ensemble:
    """What runs did, with a status that says whether their numbers are any."""
    outputs = made.outputs[:, :, : len(names)]
    status = made.numbers[:, 0].astype(np.int8)
    lost = (status < Status.UNSOLVED) & ~np.isfinite(outputs).all(axis=(1, 2))
    status[lost] = Status.NOT_FINITE
    failed = (status >= Status.UNSOLVED) & (status != Status.OUT_OF_ENVELOPE)
    columns = {name: outputs[:, :, k] for k, name in enumerate(names)}
    return Ensemble(columns, status, made.numbers[:, 1], np.where(failed, np.nan, accuracy))


def march_one_by_one(
    plan: MarchPlan,
    systems: Iterable[tuple[AbstractSystem, Sequence[Any]]],
    count: int,
    names: Sequence[str],
    tolerance: float,
) -> Ensemble:
    """Make runs on plain floats, each to a tolerance, as a share of ranges."""
    found = Ensemble.empty(names, count, len(plan.times), Status.NOT_FINITE)
    found.ended[:] = 0.0
    for run, (system, waveforms) in enumerate(systems):
        own = replace(plan, waveforms=waveforms, limits=envelope_of(system))
        try:
            functions = plan.compiled.program.bind_floats(*plan.compiled.values(system))
            one, accuracy = march_to(lambda p, f=functions: AdaptiveMarch(p, f).run(), own, tolerance)
        except ArithmeticError:  # what follows from parameters alone is no number
            continue
        rows = np.asarray(list(rows_inside(system, one.rows)))
        for name, column in found.columns.items():
            column[run, : len(rows)] = rows[:, plan.compiled.outputs.index(name)]
        found.status[run], found.ended[run] = one.status, one.time
        inside = one.status is Status.OUT_OF_ENVELOPE or not one.status.failed
        found.accuracy[run] = accuracy if inside else np.nan
    return found
