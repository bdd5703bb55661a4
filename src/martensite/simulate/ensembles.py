"""Ensembles: many runs of one system to a tolerance, each with an error bound.

Errors are bounded as in `martensite.simulate.accuracy`. Runs are batched in C
(`martensite.simulate.marching_native`), or made one by one without a compiler.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base.status import Status
from martensite.simulate.accuracy import (
    ERROR_SAFETY,
    FINER,
    LEAST_ACCURACY,
    LOCAL,
    MOST_PASSES,
    add_common,
    bound_temperature,
    choose_samples,
    choose_times,
    find_doubt,
    find_floor,
    march_to,
    shares_stress,
)
from martensite.simulate.adaptive import AdaptiveMarch
from martensite.simulate.compiled import CompiledMarch
from martensite.simulate.envelope import envelope_of, rows_inside
from martensite.simulate.forks import read_decision
from martensite.simulate.march import COARSE, SOLVED
from martensite.simulate.marching import START, STEP_TOLERANCE, MarchPlan
from martensite.simulate.marching_native import DECIDED, RANGES, MarchRows, Runs, march_runs, observe_in_c
from martensite.simulate.measures.base import AbstractMeasure
from martensite.simulate.measures.extremes import Change, Largest, Smallest, Stroke
from martensite.simulate.measures.means import ElectricalEnergy, Integral, Mean
from martensite.simulate.measures.run_table import RunTable, tabulate_samples, tabulate_track
from martensite.simulate.recorded_track import observe_on_floats
from martensite.simulate.tracing import assemble_track
from martensite.simulate.track import Track

Numbers: TypeAlias = NDArray[np.float64]
Flags: TypeAlias = NDArray[np.bool_]
Indices: TypeAlias = NDArray[np.intp]
RIPPLE, RESIDUAL = 7, 8
TOTALLED = (Largest, Smallest, Stroke, Change, Integral, ElectricalEnergy, Mean)
"""Measures that need only extremes and integrals."""


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Results of some runs of one system."""

    columns: dict[str, Numbers]
    """Outputs in SI by name, (runs, samples); NaN for refused runs and after the end of a run."""
    status: NDArray[np.int8]
    """Worst status of every run, (runs,)."""
    ended: Numbers
    """End time of every run [s], (runs,); NaN where unknown."""
    accuracy: Numbers
    """Error bound of judged outputs as a fraction of their ranges, (runs,).

    It is NaN without an estimate, and for runs that failed inside the envelope.
    """
    numbers: Numbers = field(default_factory=lambda: np.empty((0, 0)))
    """Requested measures, (measures, runs); NaN for runs that were not made."""

    @staticmethod
    def empty(names: Iterable[str], runs: int, samples: int, status: Status, measures: int = 0) -> Ensemble:
        """Return runs with a status but without data."""
        columns = {name: np.full((runs, samples), np.nan) for name in names}
        nothing = np.full(runs, np.nan)
        numbers = np.full((measures, runs), np.nan)
        return Ensemble(columns, np.full(runs, status, np.int8), nothing, nothing.copy(), numbers)

    @staticmethod
    def on_steps(
        columns: dict[str, Numbers], reports: Numbers, left: Numbers, times: Sequence[float], solved: float = SOLVED
    ) -> Ensemble:
        """Return runs on given steps with their status and time of leaving the envelope [s].

        The time is infinite for runs that stay inside; later values are NaN. Residuals up to `solved` count as zero.
        """
        residual, crossing = reports[:2]
        verdicts = {Status.NOT_FINITE: ~np.isfinite(residual), Status.UNSOLVED: residual > solved}
        verdicts[Status.LONG_STEP] = crossing > COARSE
        status = np.select(list(verdicts.values()), list(verdicts), Status.OK).astype(np.int8)
        outside = (left < np.inf) & (status < Status.UNSOLVED)
        inside = np.asarray(times) < np.where(outside, (1.0 - STEP_TOLERANCE) * left, np.inf)[:, None]
        broken = [(~np.isfinite(column) & inside).any(axis=1) for column in columns.values()]
        status[outside] = Status.OUT_OF_ENVELOPE
        status[np.logical_or.reduce(broken)] = Status.NOT_FINITE
        ended = np.where(status < Status.UNSOLVED, times[-1], np.where(outside, left, np.nan))
        valid_columns = {name: np.where(inside, column, np.nan) for name, column in columns.items()}
        return Ensemble(valid_columns, status, ended, np.full(len(left), np.nan), np.empty((0, len(left))))

    def struck_out(self, bad: Flags) -> Ensemble:
        """Return the ensemble with the data of the given runs removed."""
        columns = {name: np.where(bad[:, None], np.nan, c) for name, c in self.columns.items()}
        status = np.where(bad, np.int8(Status.REFUSED), self.status)
        numbers = np.where(bad, np.nan, self.numbers)
        return Ensemble(columns, status, np.where(bad, np.nan, self.ended), self.accuracy, numbers)

    def place_runs(self, places: Any, ensemble: Ensemble) -> None:
        """Copy other runs to the given indices."""
        for name, column in ensemble.columns.items():
            self.columns[name][places] = column
        self.status[places], self.ended[places] = ensemble.status, ensemble.ended
        self.accuracy[places], self.numbers[:, places] = ensemble.accuracy, ensemble.numbers

    @staticmethod
    def concatenate(pieces: Sequence[Ensemble]) -> Ensemble:
        """Return several ensembles in one."""
        names = pieces[0].columns
        columns = {name: np.concatenate([p.columns[name] for p in pieces]) for name in names}
        status, ended, accuracy = (
            np.concatenate([getattr(p, name) for p in pieces]) for name in ("status", "ended", "accuracy")
        )
        return Ensemble(columns, status, ended, accuracy, np.concatenate([p.numbers for p in pieces], axis=1))


@dataclass(frozen=True, eq=False)
class EnsembleMeasures:
    """Measures of runs, with the indices of their outputs."""

    measures: Sequence[AbstractMeasure] = ()
    columns: Sequence[Sequence[int]] = ()
    """Indices of outputs by measure."""

    def measure_track(self, track: Track, runs: int) -> Numbers:
        """Return all measures from the accepted steps, (measures, runs)."""
        measures = np.empty((len(self.measures), runs))
        with np.errstate(all="ignore"):  # failed runs
            for row, one, columns in zip(measures, self.measures, self.columns, strict=True):
                row[:] = one.value(tabulate_track(track, columns, runs, one.follows_curve))
        return measures

    def measure_samples(self, times: Sequence[float], table: Numbers) -> Numbers:
        """Return all measures from stored samples, (outputs, samples, runs)."""
        measures = np.empty((len(self.measures), table.shape[2]))
        with np.errstate(all="ignore"):
            for row, one, columns in zip(measures, self.measures, self.columns, strict=True):
                row[:] = one.value(tabulate_samples(np.asarray(times), table[list(columns)]))
        return measures

    @property
    def totalled(self) -> bool:
        """Return whether extremes and integrals from C suffice for the measures."""
        return all(type(one) in TOTALLED for one in self.measures)

    def measure_march(self, runs: Runs, march_rows: MarchRows, last: Indices, ranges: Numbers) -> Numbers:
        """Return all measures of the runs `last` in C, (measures, len(last)), from totals, tracks or samples.

        Args:
            runs: all runs.
            march_rows: their results.
            last: indices of the measured runs.
            ranges: known ranges of judged outputs of all runs, (runs, judged).
        """
        with np.errstate(all="ignore"):  # failed runs
            if not self.measures:
                return np.empty((0, len(last)))
            if runs.plan.totalled:
                return self.measure_totals(march_rows, runs.plan.times[-1])[:, last]
            runs, march_rows = runs.choose(last, ranges[last]), march_rows.choose(last)
            if len(march_rows.record):
                return self.measure_record(runs, march_rows)
            return self.measure_samples(runs.plan.times, np.moveaxis(march_rows.outputs, 0, 2).swapaxes(0, 1))

    def measure_totals(self, march_rows: MarchRows, duration: float) -> Numbers:
        """Return all measures of runs in C from their totals, (measures, runs)."""
        runs = len(march_rows.totals)
        measures, ones = np.empty((len(self.measures), runs)), np.ones((1, runs))
        for row, one, columns in zip(measures, self.measures, self.columns, strict=True):
            low, high, integral = np.moveaxis(march_rows.totals[:, :, list(columns)], 0, 2)
            first = march_rows.outputs[:, 0, list(columns)].T
            times, weights = (np.concatenate([0.0 * ones, last * ones]) for last in (duration, 1.0))
            row[:] = one.value(RunTable(times, np.stack([first, integral], axis=1), weights, high, low))
        return measures

    def measure_record(self, runs: Runs, march_rows: MarchRows) -> Numbers:
        """Return all measures of runs in C from their records, (measures, runs)."""
        order = np.argsort(march_rows.record[:, 0].astype(np.int32), kind="stable")
        outside = march_rows.numbers[:, 0] == Status.OUT_OF_ENVELOPE
        if outside.any():
            run, part = march_rows.record[order, 0].astype(np.intp), march_rows.record[order, 1]
            ends = np.append(run[1:] != run[:-1], True)
            order = order[~((ends | np.append(ends[1:], False)) & outside[run] & (part != START))]
        record = march_rows.record[order]
        waveforms = runs.own or [runs.plan.waveforms]
        track = assemble_track(runs.plan, record, runs.outputs, observe_in_c(runs), waveforms)
        return self.measure_track(track, runs.size)


NO_MEASURES = EnsembleMeasures()


def march_in_lanes(
    runs: Runs,
    names: Sequence[str],
    tolerance: float,
    march: Callable[[Runs], MarchRows] = march_runs,
    measuring: EnsembleMeasures = NO_MEASURES,
) -> Ensemble:
    """Simulate runs in C to a relative tolerance, which replaces the tolerance of their plan."""
    plan, compiled = runs.plan, runs.plan.compiled
    outputs = tuple(dict.fromkeys((*runs.outputs, *compiled.judged)))
    judged_columns = [outputs.index(place) for place in compiled.judged]
    compared, local = choose_samples(len(plan.times)), LOCAL[plan.order] * tolerance
    some = plan._replace(times=choose_times(plan.times), tolerance=local)
    whole = runs._replace(outputs=outputs)
    before = march(whole._replace(plan=some._replace(recorded=False, totalled=False)))
    judged, numbers = _read_judged(before.outputs, judged_columns), before.numbers
    ensemble = Ensemble.empty(names, runs.size, len(plan.times), Status.OK, len(measuring.measures))
    left = np.arange(runs.size)
    for turn in range(MOST_PASSES):
        local /= FINER
        ranges = float(turn > 0 or not shares_stress(compiled)) * numbers[:, RANGES:]
        finer = whole._replace(plan=plan._replace(tolerance=local, parted=True))
        finer = finer.choose(left, ranges) if turn else finer._replace(ranges=ranges)
        march_rows = march(finer)
        now = _read_judged(march_rows.outputs.take(compared, 1), judged_columns)
        apart = judged - now
        np.abs(apart, out=apart)
        bound = _bound_errors(compiled, apart, march_rows)
        rest = bound > tolerance
        effects = _find_effects(compiled, np.maximum(bound, find_floor(compiled) * tolerance), march_rows)
        accuracy = np.maximum(add_common(compiled, bound, tolerance), effects)
        last = np.flatnonzero(~rest | (turn == MOST_PASSES - 1))
        measured = np.full((len(measuring.measures), len(left)), np.nan)
        if len(last):
            measured[:, last] = measuring.measure_march(finer, march_rows, last, ranges)
        ensemble.place_runs(left, _judge_runs(march_rows, names, accuracy, measured, plan.times))
        left, judged, numbers = left[rest], now[rest], march_rows.numbers[rest]
        if not len(left):
            break
    return ensemble


def _read_judged(outputs: Numbers, columns: Sequence[int]) -> Numbers:
    """Return columns of outputs, (runs, samples, outputs), as (runs, columns, samples), whose maxima are fast."""
    return np.ascontiguousarray(outputs.swapaxes(1, 2)[:, columns])


def _bound_errors(compiled: CompiledMarch, apart: Numbers, march_rows: MarchRows) -> Numbers:
    """Return error bounds of runs from the differences of two passes, (runs, judged, samples)."""
    scales = _find_scales(compiled, march_rows)
    finite = np.isfinite(apart)
    worst = (np.where(finite, apart, 0.0).max(axis=2) / scales).max(axis=1, initial=0.0)
    heat = scales[:, 0] if scales.shape[1] else 1.0
    total = np.maximum(
        ERROR_SAFETY * worst + march_rows.numbers[:, RIPPLE] / heat, ERROR_SAFETY * march_rows.numbers[:, RESIDUAL]
    )
    sure = np.isfinite(total) & finite[:, :, 0].all(axis=1)
    return np.where(sure, np.maximum(total, LEAST_ACCURACY), np.inf)


def _find_scales(compiled: CompiledMarch, march_rows: MarchRows) -> Numbers:
    """Return the ranges of the judged outputs of runs, at least those that count, (runs, judged)."""
    return np.maximum(march_rows.numbers[:, RANGES:], [least for _, least in compiled.convergence_scales])


def _find_effects(compiled: CompiledMarch, accuracy: Numbers, march_rows: MarchRows) -> Numbers:
    """Return the effects of decisions that the errors of their runs may change; 0 for other runs."""
    effects, ranges = np.zeros(len(accuracy)), march_rows.numbers[:, RANGES:]
    if compiled.forks:
        scales = list(_find_scales(compiled, march_rows).T)
        largest_error = np.max([bound_temperature(fork, accuracy, scales) for fork in compiled.forks], axis=0)
        near = np.flatnonzero(np.abs(march_rows.numbers[:, DECIDED]) <= largest_error)
        decisions = map(read_decision, march_rows.numbers[near, DECIDED:RANGES].tolist())
        runs = zip(decisions, accuracy[near].tolist(), ranges[near].tolist(), strict=True)
        effects[near] = [find_doubt(compiled, *run)[1] for run in runs]
    return effects


def _judge_runs(
    march_rows: MarchRows, names: Sequence[str], accuracy: Numbers, measured: Numbers, times: Sequence[float]
) -> Ensemble:
    """Return the runs with a status that matches their data."""
    outputs = march_rows.outputs[:, :, : len(names)]
    status = march_rows.numbers[:, 0].astype(np.int8)
    lost = (status < Status.UNSOLVED) & ~np.isfinite(outputs).all(axis=(1, 2))
    status[lost] = Status.NOT_FINITE
    failed = (status >= Status.UNSOLVED) & (status != Status.OUT_OF_ENVELOPE)
    columns = {name: outputs[:, :, k] for k, name in enumerate(names)}
    ended = march_rows.numbers[:, 1].copy()
    for run in np.flatnonzero(status == Status.OUT_OF_ENVELOPE):
        ended[run] = _bound_end(ended[run], int(np.isfinite(outputs[run]).all(axis=1).sum()), times)
    return Ensemble(columns, status, ended, np.where(failed, np.nan, accuracy), measured)


def _bound_end(ended: float, valid_count: int, times: Sequence[float]) -> float:
    """Return the end [s] of a run that left the envelope, at most the first missing sample."""
    return min(ended, times[min(valid_count, len(times) - 1)])


def march_one_by_one(
    plan: MarchPlan,
    systems: Iterable[tuple[AbstractSystem, Sequence[Any]]],
    count: int,
    names: Sequence[str],
    tolerance: float,
    measuring: EnsembleMeasures,
) -> Ensemble:
    """Simulate runs on plain floats to a relative tolerance."""
    ensemble = Ensemble.empty(names, count, len(plan.times), Status.NOT_FINITE, len(measuring.measures))
    places = [plan.compiled.outputs.index(name) for name in names]
    ensemble.ended[:] = 0.0
    for run, (system, waveforms) in enumerate(systems):
        own = plan._replace(waveforms=waveforms, limits=envelope_of(system))
        try:
            functions = plan.compiled.program.bind_floats(*plan.compiled.values(system))
            one, accuracy = march_to(lambda p, f=functions: AdaptiveMarch(p, f).run(), own, tolerance)
        except ArithmeticError:  # a value that depends on parameters alone is not finite
            continue
        rows = np.asarray(list(rows_inside(system, one.rows)))
        for name, column in ensemble.columns.items():
            column[run, : len(rows)] = rows[:, plan.compiled.outputs.index(name)]
        if measuring.measures:
            observe = observe_on_floats(functions["observe"], places)
            track = assemble_track(own._replace(tolerance=tolerance), one.record, places, observe, [waveforms])
            ensemble.numbers[:, run] = measuring.measure_track(track, 1)[:, 0]
        ensemble.status[run], ensemble.ended[run] = one.status, one.time
        if one.status is Status.OUT_OF_ENVELOPE:
            ensemble.ended[run] = _bound_end(one.time, len(rows), plan.times)
        inside = one.status is Status.OUT_OF_ENVELOPE or not one.status.failed
        ensemble.accuracy[run] = accuracy if inside else np.nan
    return ensemble
