"""Goals and slacks of designs in batches, and exact derivatives.

A design is a point z in the box of its free parameters (`martensite.search.free_numbers`). Batches run in C side by
side. The derivatives of a single design follow from

    dm/dz_k = Σ_s  (∂m/∂y_s) (∂y_s/∂p_k) (dp_k/dz_k)

with the values y_s at the ends of steps, from which a measure m is computed. Without a compiler, runs use plain floats
and derivatives are central differences. Measures are piecewise smooth: derivatives are one-sided where the hottest
sample changes or a coordinate meets a stop. They are 0 for a wire that does not transform.

A search uses scaled values (`martensite.search.box_search`). The goal is the mean over all cases, divided by its size
at the start, and negated for a maximum. A slack is the distance of a constraint from its limit in one case, as a
fraction of the limit (of 50 K for a temperature). A failed run, and an event that never happens, are far beyond every
limit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from martensite.design.optimise.question import DesignAim, DesignQuestion
from martensite.search.batch_runner import BatchRunner
from martensite.search.box_search import FAILED_GOAL, LARGEST_SLACK, JudgedPoints, PointSlopes
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.drive_waveforms import grid_of
from martensite.simulate.measures.base import list_needed
from martensite.simulate.measures.run_table import tabulate_samples
from martensite.simulate.waveform_levels import Level, WaveformLevels

CLOUD_SPREAD = 0.05
"""Scatter of the points around a design, as a fraction of ranges."""


@dataclass
class RunCounts:
    """Numbers of simulations."""

    simulations: int = 0
    """Runs without derivatives."""
    slopes: int = 0
    """Runs with derivatives."""

    def to_dict(self) -> dict[str, int]:
        """Return plain values."""
        return {"simulations": self.simulations, "with_derivatives": self.slopes}


class AimSlopes(NamedTuple):
    """Aims of a design and their derivatives."""

    values: Numbers
    """(cases, aims)"""
    slopes: Numbers
    """Derivatives by the place z of each free parameter, (cases, aims, free)."""


class DesignEvaluator:
    """Evaluator of the designs of a question."""

    differentiable, partial = True, False

    def __init__(
        self,
        steering: WaveformLevels,
        question: DesignQuestion,
        *,
        samples: int,
        step: float,
        also: Sequence[DesignAim] = (),
        native: bool | None = None,
    ) -> None:
        """Prepare runs with `samples` samples, both ends included, in steps [s] of at most `step`.

        The measures `also` are reported without derivatives. `native` runs in C, by default if there is a compiler.

        Raises:
            ParameterError: a level of a waveform cannot be free.
        """
        levels = [c.level for one in question.free for c in one.targets if c.level is not None]
        self.steering = steering.with_levels(levels)
        self.question, self.step, self.counts = question, step, RunCounts()
        self.samples = samples
        self.goal_size = 1.0
        """Divisor of goals [SI]."""
        self.widths = np.ones(len(question.free))
        self.scatter = CLOUD_SPREAD * self.widths
        self.system = self.steering.whole
        played = self.steering.system_waveforms()
        self.grid = grid_of(self.system, played, steering.duration, samples, step, every=True)
        self.times = np.array(self.grid.times)
        self.also = tuple(also)
        every = [aim.measure for aim in (*question.aims, *also) if aim.measure is not None]
        self.outputs = list_needed(every, self.system)
        self.runner = BatchRunner(self.system, self.grid, self.outputs, native=native)
        self.native = self.runner.native
        self._rows = [[self._find_row(c.path, c.level) for c in one.targets] for one in question.free]

    def numbers(self, z: Numbers) -> Numbers:
        """Return the free parameters [SI] at places, (..., free)."""
        columns = [one.value(z[..., k]) for k, one in enumerate(self.question.free)]
        return np.stack(columns, axis=-1)

    def values(self, z: Numbers) -> Numbers:
        """Return the aims of designs, (designs, free) -> (designs, cases, aims); NaN for failed runs."""
        return self.evaluate_aims(self.numbers(z), self.aims)

    def evaluate_aims(self, numbers: Numbers, aims: Sequence[DesignAim]) -> Numbers:
        """Return aims for parameters [SI], (designs, free) -> (designs, cases, aims); NaN for failed runs."""
        cases, table = len(self.question.cases), self._fill_table(numbers)
        self.counts.simulations += len(table)
        samples, every = self.runner.run_many(table).T, np.repeat(numbers, cases, axis=0)
        values = np.stack([self._value(aim, samples, every) for aim in aims], axis=1)
        values[~np.isfinite(samples).all(axis=(0, 1))] = np.nan
        return values.reshape(len(numbers), cases, -1)

    def slopes(self, z: Numbers) -> AimSlopes | None:
        """Return the aims of one design with derivatives; None if a run fails."""
        inner = np.array([one.slope(p) for one, p in zip(self.question.free, z, strict=True)])
        seeds = np.zeros((len(self.runner.paths), len(self._rows)))
        for k, rows in enumerate(self._rows):
            seeds[rows, k] = inner[k]
        values: list[Numbers] = []
        slopes: list[Numbers] = []
        numbers = self.numbers(z[None, :])
        for row in self._fill_table(numbers):
            self.counts.slopes += 1
            run = self.runner.run_slopes(row, seeds)
            if run is None:
                return None
            samples, moved = run[0].T, np.moveaxis(run[1], 0, 1)
            values.append(np.array([self._value(aim, samples[:, :, None], numbers)[0] for aim in self.aims]))
            slopes.append(np.stack([self._slope(aim, samples[:, :, None], moved) for aim in self.aims]))
        own = self._own_slopes() * inner
        return AimSlopes(np.stack(values), np.stack(slopes) + own)

    @property
    def aims(self) -> tuple[DesignAim, ...]:
        """Return the aims, the goal first."""
        return self.question.aims

    def course(self, numbers: Numbers, output: str) -> Numbers:
        """Return an output of one design [SI] in the first case, (samples,); NaN for a failed run."""
        self.counts.simulations += 1
        runner = BatchRunner(self.system, self.grid, [output], native=self.native)
        return runner.run_many(self._fill_table(numbers[None, :])[:1])[0, :, 0]

    # ---------------------------------------------------------------- as a search sees them

    @property
    def runs(self) -> int:
        """Return the number of runs."""
        return self.counts.simulations + self.counts.slopes

    @property
    def sign(self) -> float:
        """Return 1 for a goal to minimise, else -1."""
        return -1.0 if self.question.is_maximised else 1.0

    def restore_goal(self, goal: float) -> float:
        """Return a scaled goal in SI."""
        return self.sign * self.goal_size * goal

    def set_size(self, values: Numbers) -> None:
        """Set the size of the goal from designs, (designs, cases, aims)."""
        goals = np.abs(values[:, :, 0].mean(axis=1))
        goals = goals[np.isfinite(goals) & (goals > 0.0)]
        self.goal_size = float(np.median(goals)) if len(goals) else 1.0

    def judge(self, z: Numbers) -> JudgedPoints:
        """Return the goals and slacks of designs (designs, free)."""
        return self.judge_values(self.values(z))

    def judge_values(self, values: Numbers) -> JudgedPoints:
        """Return the goals and slacks of values, (designs, cases, aims)."""
        goal = self.sign * values[:, :, 0].mean(axis=1) / self.goal_size
        slack = [c.sign * (values[:, :, k + 1] - c.limit) / c.scale for k, c in enumerate(self.question.subject)]
        table = np.stack(slack, axis=2).reshape(len(values), -1) if slack else goal[:, None][:, :0]
        most = LARGEST_SLACK
        bounded = np.clip(np.nan_to_num(table, nan=-most, posinf=most, neginf=-most), -most, most)
        bounded[np.isnan(values).any(axis=(1, 2))] = -most
        return JudgedPoints(np.where(np.isfinite(goal), goal, FAILED_GOAL), bounded)

    def differentiate(self, z: Numbers) -> PointSlopes | None:
        """Return goal and slacks of a design with derivatives; None if a run fails."""
        aims = self.slopes(z)
        if aims is None:
            return None
        one = self.judge_values(aims.values[None])
        slope = self.sign * aims.slopes[:, 0].mean(axis=0) / self.goal_size
        rows = [c.sign * aims.slopes[:, k + 1] / c.scale for k, c in enumerate(self.question.subject)]
        table = np.stack(rows, axis=1).reshape(-1, len(z)) if rows else np.zeros((0, len(z)))
        table = np.where((np.abs(one.slack[0]) < LARGEST_SLACK)[:, None], table, 0.0)
        return PointSlopes(float(one.goal[0]), one.slack[0], slope, table)

    # ---------------------------------------------------------------- tables of parameters

    def _find_row(self, path: str, level: Level | None) -> int:
        steering = self.steering
        whole = steering.path(path) if level is None else steering.level_path(level)
        return self.runner.place(whole)

    def _fill_table(self, numbers: Numbers) -> Numbers:
        """Return the parameters of every design in every case, (designs * cases, parameters)."""
        cases = self.question.cases
        table = self.runner.table({}, len(numbers) * len(cases))
        for rows, column in zip(self._rows, numbers.T, strict=True):
            for row in rows:
                table[:, row] = np.repeat(column, len(cases))
        for k, case in enumerate(cases):
            for path, value in case.items():
                table[k :: len(cases), self._find_row(path, None)] = value
        return table

    # ---------------------------------------------------------------- measures

    def _select_columns(self, aim: DesignAim, samples: Numbers) -> Numbers:
        """Return the columns of a measure."""
        measure = aim.measure
        names = () if measure is None else measure.columns(self.system)
        return samples[[self.outputs.index(name) for name in names]]

    def _value(self, aim: DesignAim, samples: Numbers, numbers: Numbers) -> Numbers:
        if aim.measure is None:
            return numbers[:, aim.place or 0]
        return aim.measure.value(tabulate_samples(self.times, np.nan_to_num(self._select_columns(aim, samples))))

    def _slope(self, aim: DesignAim, samples: Numbers, moved: Numbers) -> Numbers:
        """Return d(measure)/d(parameter), (free,)."""
        if aim.measure is None:
            return np.zeros(moved.shape[2])
        weights = aim.measure.derivatives(tabulate_samples(self.times, self._select_columns(aim, samples)))[:, :, 0]
        return np.einsum("cs,csf->f", weights, self._select_columns(aim, moved))

    def _own_slopes(self) -> Numbers:
        """Return d(aim)/d(parameter) of aims that are free parameters, (aims, free)."""
        slopes = np.zeros((len(self.aims), len(self.question.free)))
        for k, aim in enumerate(self.aims):
            if aim.place is not None:
                slopes[k, aim.place] = 1.0
        return slopes


def apply_numbers(steering: WaveformLevels, question: DesignQuestion, numbers: Sequence[float]) -> WaveformLevels:
    """Return the system and waveforms of a design; `ParameterError` if the system refuses the values."""
    pairs = [(c, float(v)) for one, v in zip(question.free, numbers, strict=True) for c in one.targets]
    system = steering.system.with_values({c.path: v for c, v in pairs if c.level is None})
    waves = dict(steering.own)
    for drive in waves:
        moved = {c.level.name: v for c, v in pairs if c.level and c.level.drive == drive}
        waves[drive] = steering.at(drive, moved)
    return replace(steering, system=system, waveforms=waves, levels=())
