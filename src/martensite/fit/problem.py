"""Problem of a fit: experiments, free parameters, and residuals with their Jacobian.

    r = √w (y(p) + offset - measured)/scale

The residuals cover all fitted samples. `scale` is the given noise of an output, or otherwise its measured range. The
cost is the mean of r². With a C compiler, derivatives with respect to the fractions u of the search are exact.
"""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, fields, replace
from functools import cache, cached_property
from os import cpu_count
from typing import Any

import numpy as np

from martensite.base.errors import InputError, ParameterError
from martensite.fit.evaluation import Evaluation, FittedRecord, InputCorrection
from martensite.fit.experiment import ALL, Experiment
from martensite.fit.free_parameters import (
    DELAY,
    OFFSET,
    SPREADS,
    build_free_numbers,
    build_own_parameters,
    delay_model,
    is_nuisance,
)
from martensite.fit.moved_values import MovedRows, find_moved_rows, refuse_double, refuse_late_base, weigh_spreads
from martensite.fit.ordered_numbers import OrderedNumbers, list_orders
from martensite.search.batch_runner import BatchRunner
from martensite.search.free_numbers import FreeNumber, SearchRange
from martensite.simulate.refusals import find_refused

FEW_STEPS = 10_000
"""Number of steps of all runs below which threads are not worthwhile."""


@dataclass(frozen=True)
class Problem:
    """Fit problem: experiments, free parameters and options."""

    experiments: tuple[Experiment, ...]
    free: tuple[FreeNumber, ...]
    noise: Mapping[str, float] = field(default_factory=dict[str, float])
    """Output -> standard deviation of its measurement [SI], if known."""
    step: float | None = None
    """Longest step of all runs [s]; None for the step of each experiment."""
    later: tuple[FreeNumber, ...] = ()
    """Separate parameters of held-out records, fitted afterwards."""
    input_noise: Mapping[str, float] = field(default_factory=dict[str, float])
    """Drive column -> standard deviation of its noise [SI], if known."""
    corrections: tuple[InputCorrection, ...] = ()
    """One correction per experiment, if noise of its drives matters."""
    prior_scale: float = 1.0
    """Noise of residuals, as the weight of spreads; 1 if all noise is known."""

    def __post_init__(self) -> None:
        """Raise `ParameterError` for a problem that has no solution."""
        if not self.experiments:
            raise ParameterError("A fit needs at least one record; none given.")
        if not self.free:
            raise ParameterError("A fit needs at least one free parameter; none given.")
        for kind, names in (("record", [one.name for one in self.experiments]), ("free parameter", list(self.names))):
            double = next((name for name in names if names.count(name) > 1), None)
            if double is not None:
                raise ParameterError(f"There are two of {kind} `{double}`; give each its own name.")
        if all(one.is_held_out for one in self.experiments):
            raise ParameterError("All records are held out, so no data are left for the fit.")
        refuse_late_base(self.free)
        for one in self.experiments:
            refuse_double(one, self.free)

    def __getstate__(self) -> dict[str, Any]:
        """Return the declared fields; derived state, such as threads, is rebuilt in the other process."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the free parameters."""
        return tuple(free.name for free in self.free)

    @property
    def start(self) -> Any:
        """Return the start of the search: a fraction from 0 to 1 for every free parameter."""
        return self.order.repair(np.array([free.share(free.start) for free in self.free]))

    @cached_property
    def order(self) -> OrderedNumbers:
        """Return the order constraints that the laws declare."""
        return OrderedNumbers(self.free, list_orders(self.free, self.experiments))

    @property
    def training(self) -> Problem:
        """Return the problem without the held-out records."""
        return replace(self, experiments=tuple(one for one in self.experiments if not one.is_held_out), later=())

    def hold_out(self, names: Container[str]) -> Problem:
        """Return the problem with some records held out.

        Their separate parameters are fitted afterwards; parameters with a spread stay at their centres.
        """
        experiments = [replace(one, held_out_intervals=ALL) if one.name in names else one for one in self.experiments]
        labels = {None, *(label for one in experiments if not one.is_held_out for label in one.labels)}
        rest = [x for x in self.free if x.record not in labels]
        return replace(
            self,
            experiments=tuple(_set_centres(one, rest) if one.is_held_out else one for one in experiments),
            free=tuple(x for x in self.free if x.record in labels),
            later=(*self.later, *(x for x in rest if not x.spread)),
        )

    def numbers(self, u: Sequence[float]) -> dict[str, float]:
        """Return the free parameters in SI."""
        return {free.name: free.value(float(x)) for free, x in zip(self.free, u, strict=True)}

    def scale(self, output: str) -> float:
        """Return the divisor of residuals of an output [SI]."""
        if output in self.noise:
            return self.noise[output]
        return self._ranges[output]

    @cached_property
    def _ranges(self) -> dict[str, float]:
        ranges: dict[str, float] = {}
        columns: dict[str, list[Any]] = {}
        for one in self.experiments:
            for k, output in enumerate(one.outputs):
                column = one.measured[:, k]
                if not one.over_time:  # variance between specimens counts
                    columns.setdefault(output, []).append(column)
                    column = np.concatenate(columns[output])
                reach = float(np.nanmax(column) - np.nanmin(column))
                ranges[output] = max(ranges.get(output, 0.0), reach)
        return ranges

    @cached_property
    def runners(self) -> tuple[BatchRunner, ...]:
        """Return one runner per experiment."""
        runners = tuple(one.runner(self.step) for one in self.experiments)
        return self._drive_runners(runners) if self.corrections else runners

    def _drive_runners(self, runners: Sequence[BatchRunner]) -> tuple[BatchRunner, ...]:
        """Return the runners that follow the corrected instead of the logged drives."""
        rows = zip(runners, self.experiments, self.corrections, strict=True)
        return tuple(
            runner.with_grid(one.driven_grid([fix.inputs], self.step).lane(0)) if fix.inputs else runner
            for runner, one, fix in rows
        )

    def with_corrections(self, corrections: Sequence[InputCorrection]) -> Problem:
        """Return the problem with corrections for noise of its drives."""
        problem = replace(self, corrections=tuple(corrections))
        caches = {name: getattr(self, name) for name in ("_ranges", "training_rows", "_moving", "_values")}
        problem.__dict__.update(caches, runners=problem._drive_runners(self.runners))  # cached values that stay valid
        return problem

    @cached_property
    def training_rows(self) -> list[Any]:
        """Return the fitted samples of every experiment, True in arrays (rows, outputs)."""
        return [np.isfinite(one.measured) & ~one.held_out_rows[:, None] for one in self.experiments]

    def evaluate(self, u: Sequence[float], *, slopes: bool = False) -> Evaluation | None:
        """Return the residuals at a point, with their Jacobian on request; None if a run fails."""
        fitted = self._run_all(u, slopes)
        if fitted is None:
            return None
        residuals = [self._list_residuals(k, one) for k, one in enumerate(fitted)]
        jacobian = [self._list_slopes(k, one) for k, one in enumerate(fitted)] if slopes else []
        if self.spreads:
            apart, by_numbers = weigh_spreads(self.free, self.spreads, u, self.prior_scale)
            residuals.append(apart)
            jacobian.append(by_numbers)
        return Evaluation(fitted, np.concatenate(residuals), np.concatenate(jacobian) if slopes else None)

    def _run_all(self, u: Sequence[float], slopes: bool) -> tuple[FittedRecord, ...] | None:
        """Return the runs of all experiments at a point; None if a run fails."""
        moved = [self.change_values(k, u) for k in range(len(self.runners))]
        if any(values is None for values in moved):
            return None
        jobs = [(k, values, u, slopes) for k, values in enumerate(moved)]
        steps = sum(len(runner.grid.lengths) for runner in self.runners)
        started = map if steps < FEW_STEPS else _start_threads().map
        fitted = tuple(one for one in started(lambda job: self._evaluate_one(*job), jobs) if one is not None)
        return fitted if len(fitted) == len(jobs) else None

    def split(self, residuals: Any) -> list[Any]:
        """Return the residuals of fitted samples, by experiment."""
        ends = np.cumsum([int(used.sum()) for used in self.training_rows])
        return np.split(residuals[: ends[-1]], ends[:-1])

    @property
    def knows_noise(self) -> bool:
        """Return whether the noise of all compared outputs is known."""
        return all(name in self.noise for one in self.experiments for name in one.outputs)

    @cached_property
    def spreads(self) -> list[tuple[int, int | None]]:
        """Return the indices of every parameter with a spread and of its common centre."""
        common = {free.path: i for i, free in enumerate(self.free) if free.record is None}
        return [(i, common.get(free.path)) for i, free in enumerate(self.free) if free.spread and free.record]

    def costs(self, points: Any) -> Any:
        """Return the costs (m,) of many points (m, free), in batches; inf where a run fails."""
        totals, counts = np.zeros(len(points)), 0
        for k, runner in enumerate(self.runners):
            table, refused = self._tabulate_values(k, points)
            for i, (u, model) in enumerate(zip(points, runner.run_many(table), strict=True)):
                fitted = self._compare_model(k, None if refused[i] else model, u, None)
                totals[i] += math.inf if fitted is None else self._sum_squares(k, fitted)
            counts += int(self.training_rows[k].sum())
        if self.spreads:
            totals += np.array(
                [float(np.sum(weigh_spreads(self.free, self.spreads, u, self.prior_scale)[0] ** 2)) for u in points]
            )
        return totals / (counts + len(self.spreads))

    def _list_slopes(self, k: int, fitted: FittedRecord) -> Any:
        """Return the derivatives (n, free) of the used residuals of an experiment."""
        slopes = fitted.jacobian.transpose(1, 0, 2)[self.training_rows[k].T]
        return self.corrections[k].whiten(slopes) if self.corrections else slopes

    def _sum_squares(self, k: int, fitted: FittedRecord) -> float:
        total = float(np.sum(self._list_residuals(k, fitted) ** 2))
        return total if math.isfinite(total) else math.inf

    def _list_residuals(self, k: int, fitted: FittedRecord) -> Any:
        """Return the used residuals (n,) of an experiment, corrected for noise of its drives."""
        residuals = fitted.residuals.T[self.training_rows[k].T]
        if not self.corrections:
            return residuals
        fix = self.corrections[k]
        return fix.whiten(residuals + fix.shift)

    @property
    def lengths(self) -> list[int]:
        """Return the number of residuals of each output of each experiment."""
        counts = (int(n) for used in self.training_rows for n in used.sum(axis=0))
        return [n for n in counts if n] + [1] * len(self.spreads)

    @cached_property
    def _moving(self) -> list[MovedRows]:
        rows = zip(self.experiments, self.runners, strict=True)
        return [find_moved_rows(self.free, one.labels, list(runner.paths)) for one, runner in rows]

    def system(self, k: int, u: Sequence[float]) -> Any:
        """Return the system of an experiment with its parameters at a point.

        Raises:
            InputError: values contradict each other.
        """
        paths = self.runners[k].paths
        changed: dict[str, float] = {}
        for i, places in self._moving[k]:
            for j, base in places:
                below = 0.0
                if base is not None:
                    below = changed.get(paths[base], float(self.runners[k].base[base]))
                changed[paths[j]] = below + self.free[i].value(float(u[i]))
        return self.experiments[k].system.with_values(changed)

    @cached_property
    def _values(self) -> dict[int, tuple[tuple[float, ...], Any]]:
        """Return the last point and its parameter values, by experiment."""
        return {}

    def change_values(self, k: int, u: Sequence[float]) -> Any:
        """Return the parameter values of an experiment at a point; None if they are inconsistent."""
        point = tuple(map(float, u))
        if self._values.get(k, ((),))[0] != point:
            try:
                self._values[k] = point, np.array(self.runners[k].compiled.values(self.system(k, point)))
            except InputError:
                return None
        return self._values[k][1]

    def _tabulate_values(self, k: int, points: Any) -> tuple[Any, Any]:
        """Return `change_values` of many points, (m, parameters), and a mask of inconsistent points, (m,)."""
        runner = self.runners[k]
        table = np.repeat(np.asarray(runner.base)[None], len(points), axis=0)
        for i, places in self._moving[k]:
            moved = np.array([self.free[i].value(float(u[i])) for u in points])
            for j, base in places:
                table[:, j] = moved if base is None else table[:, base] + moved
        paths = {runner.paths[j]: table[:, j] for _, places in self._moving[k] for j, _ in places}
        refused = find_refused(self.experiments[k].system, paths, len(points))
        table[refused] = runner.base
        return table, refused

    def _evaluate_one(self, k: int, values: Any, u: Sequence[float], slopes: bool) -> FittedRecord | None:
        if not slopes:
            return self._compare_model(k, self.runners[k].run_one(values), u, None)
        seeds = np.zeros((len(values), len(self.free)))
        for i, places in self._moving[k]:
            for j, base in places:
                seeds[j] = 0.0 if base is None else seeds[base]
                seeds[j, i] += self.free[i].slope(float(u[i]))
        moving = seeds.any(axis=0)
        run = self.runners[k].run_slopes(values, seeds[:, moving])
        if run is None:
            return None
        spread = np.zeros((*run[0].shape, len(self.free)))
        spread[:, :, moving] = run[1]
        return self._compare_model(k, run[0], u, spread)

    def _compare_model(self, k: int, model: Any, u: Sequence[float], slopes: Any) -> FittedRecord | None:
        """Return the residuals of a run, with the offsets and the delay of its record."""
        if model is None:
            return None
        model, slopes = self.shift_model(k, model, u, slopes)
        sizes = self.residual_sizes(k) * self.experiments[k].row_factors
        residuals = (model - self.experiments[k].measured) * sizes
        return FittedRecord(model, residuals, None if slopes is None else slopes * sizes[..., None])

    def residual_sizes(self, k: int) -> Any:
        """Return the weights of errors of every output of an experiment."""
        one = self.experiments[k]
        return np.array([math.sqrt(one.weights.get(name, 1.0)) / self.scale(name) for name in one.outputs])

    def shift_model(self, k: int, model: Any, u: Sequence[float], slopes: Any) -> tuple[Any, Any]:
        """Return a run with the offsets and the delay of its record, and derivatives of both."""
        one = self.experiments[k]
        for i, free in enumerate(self.free):
            if free.record in one.labels and is_nuisance(free.path):
                value, slope = free.value(float(u[i])), free.slope(float(u[i]))
                if free.path == DELAY:
                    model, slopes = delay_model(one.times, model, slopes, value, slope, i)
                else:
                    place = one.outputs.index(free.path.removeprefix(OFFSET + "."))
                    model = model.copy()
                    model[:, place] += value
                    if slopes is not None:
                        slopes[:, place, i] += slope
        return model, slopes


@cache
def _start_threads() -> ThreadPoolExecutor:
    """Return the threads for runs in C, which release the interpreter lock."""
    return ThreadPoolExecutor(max(1, cpu_count() or 1))


def build_problem(
    experiments: Sequence[Experiment],
    free: Sequence[SearchRange | str],
    *,
    each: Sequence[SearchRange | str] = (),
    noise: Mapping[str, float] | None = None,
    step: float | None = None,
    input_noise: Mapping[str, float] | None = None,
) -> Problem:
    """Return a problem from experiments and names.

    Args:
        experiments: at least one experiment, with distinct names.
        free: parameters common to all experiments.
        each: separate parameters of every experiment: parameters, `offset.OUTPUT`, `delay`.
        noise: output -> standard deviation of its measurement [SI].
        step: longest step of all runs [s].
        input_noise: drive column -> standard deviation of its noise [SI].

    Raises:
        InputError: a name is unknown or repeated, or bounds are impossible.
    """
    systems = [one.system for one in experiments]
    shared = build_free_numbers([_read_name(x) for x in free], systems)
    ranges = [_read_name(x) for x in each]
    own = [_open_range(x, shared) for x in build_own_parameters(ranges, experiments)]
    whole = Problem(tuple(experiments), (*shared, *own), noise or {}, step, (), input_noise or {})
    return whole.hold_out([one.name for one in experiments if one.is_held_out])


def _open_range(own: FreeNumber, shared: Sequence[FreeNumber]) -> FreeNumber:
    """Return a parameter with a spread about a free centre, with the bounds and start of that centre."""
    centre = next((x for x in shared if x.path == own.path and own.spread), None)
    if centre is None:
        return own
    reach = SPREADS * own.spread
    if own.relative:
        low, high = centre.low * math.exp(-reach), centre.high * math.exp(reach)
    else:
        low, high = centre.low - reach, centre.high + reach
    return replace(own, low=low, high=high, start=min(max(own.start, low), high))


def _set_centres(one: Experiment, rest: Sequence[FreeNumber]) -> Experiment:
    """Return a held-out record with its random effects at their centres."""
    own = [x for x in rest if x.spread and x.record in one.labels and not is_nuisance(x.path)]
    centres = {leaf.path: x.start for x in own for leaf in one.system.leaves() if x.moves(leaf.path)}
    return replace(one, system=one.system.with_values(centres)) if centres else one


def _read_name(name: SearchRange | str) -> SearchRange:
    return SearchRange(name) if isinstance(name, str) else name
