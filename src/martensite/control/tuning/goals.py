"""Goal of a tuned loop: a smooth cost with derivatives.

    cost = E + w_o O + w_e P + w_a A

    E = Σ t |e|/(Σ t Δ)  (itae),   mean |e|/Δ  (iae),   mean e²/Δ²  (ise)
    O = (mean max(0, beyond)⁸)^(1/8)/Δ         overshoot
    P = mean power/P₀                          energy
    A = mean |u_k - u_k-1|/U                   activity of the signal

with the error e = r - y, the span Δ of the reference and the initial output, and the mean power P₀ and the range U of
the signal in a first run. Every part is a ratio, and its weight is relative to the error. The time t of ITAE restarts
at every step of the reference, a change by more than 5 % of Δ within a sample. `beyond` is the excess of the output
over the new level, from a step until the reference moves again. |x| is √(x² + δ²) - δ with δ a thousandth of the span;
a power mean of order 8 approximates the largest excess.

The cost of a batch of plants is the mean of their costs, or the mean over the worst fraction of them (conditional value
at risk: Rockafellar and Uryasev (2000)).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.base.errors import ParameterError, suggest_name
from martensite.control.tuning.loop_runs import LoopOutputs
from martensite.signals.sampling.sampled import Numbers

ERRORS = ("itae", "iae", "ise")
STEP, SMOOTH, ORDER = 0.05, 1e-3, 8.0


@dataclass(frozen=True)
class TuningGoal:
    """Weights of the cost."""

    error: str = "itae"
    overshoot: float = 0.2
    energy: float = 0.01
    activity: float = 0.1
    worst: float = 1.0
    """Fraction of a batch that counts, its worst plants; 1 for all."""

    def __post_init__(self) -> None:
        """Raise `ParameterError` for an invalid goal."""
        if self.error not in ERRORS:
            raise ParameterError(f"There is no goal `{self.error}`. {suggest_name(self.error, ERRORS)}")
        weights = self.overshoot, self.energy, self.activity
        if not all(0.0 <= weight < math.inf for weight in weights):
            raise ParameterError("Weights of a goal must be at least 0 and finite.")
        if not 0.0 < self.worst <= 1.0:
            raise ParameterError(
                f"The fraction of a batch that counts must be above 0 and at most 1, but is {self.worst:g}."
            )

    def over_plants(self, costs: Numbers) -> tuple[float, Numbers]:
        """Return the cost of a batch, and the weight of every plant in it."""
        counted = max(math.ceil(self.worst * len(costs) - 1e-9), 1)
        weights = np.zeros(len(costs))
        weights[np.argsort(-costs, kind="stable")[:counted]] = 1.0 / counted
        return float(costs[weights > 0.0].mean()), weights


class Course:
    """A reference with the scales of the cost from a first run."""

    def __init__(self, outputs: LoopOutputs, period: float) -> None:
        """Take the scales from a run, arrays of shape (samples,).

        Raises:
            ParameterError: the reference stays where the output begins.
        """
        reference, start = outputs.reference, float(outputs.output[0])
        self.span = float(max(reference.max(), start) - min(reference.min(), start))
        if not self.span > 0.0:
            raise ParameterError("The reference stands where the output begins: nothing to tune.")
        self.period = period
        self.power = max(float(outputs.power.mean()), 1e-12)
        self.signal = max(float(np.ptp(outputs.signal)), 1e-12)
        self.change = np.diff(reference, prepend=start)
        self.steps = np.abs(self.change) > STEP * self.span
        self.steps[0] = True
        places = np.arange(len(self.steps))
        last = np.maximum.accumulate(np.where(self.steps, places, 0))
        self.clock = (places - last) * period
        self.way = self._way()

    def _way(self) -> Numbers:
        """Return the direction of the last step while the reference is constant, else 0."""
        directions = np.zeros(len(self.change))
        way = 0.0
        for k, (change, step) in enumerate(zip(self.change, self.steps, strict=True)):
            if step:
                way = float(np.sign(change))
            elif change != 0.0:
                way = 0.0
            directions[k] = way
        return directions


class Cost:
    """Costs of runs by a goal, and their derivatives."""

    def __init__(self, goal: TuningGoal, course: Course) -> None:
        self.goal, self.course = goal, course

    def __call__(self, outputs: LoopOutputs) -> Numbers:
        """Return the costs of runs, shape (runs, samples) -> (runs,); infinite for a failed run."""
        with np.errstate(invalid="ignore"):
            costs = np.asarray(self.parts(outputs)[0])
        return np.where(np.isfinite(costs), costs, np.inf)

    def slope(self, outputs: LoopOutputs, slopes: LoopOutputs) -> Numbers:
        """Return the derivatives of the cost of a run, from slopes of its outputs of shape (samples, parameters)."""
        _, output, signal, power = self.parts(outputs)
        return output @ slopes.output + signal @ slopes.signal + power @ slopes.power

    def parts(self, outputs: LoopOutputs) -> tuple[Any, Numbers, Numbers, Numbers]:
        """Return the costs, and their derivatives by output, signal and power at every sample."""
        goal, course = self.goal, self.course
        error, by_output = self._error(outputs.output - outputs.reference)
        beyond, more = self._overshoot(outputs.output - outputs.reference)
        moved, by_signal = _smooth_size(np.diff(outputs.signal) / course.signal)
        count = max(moved.shape[-1], 1)
        energy = outputs.power.mean(-1) / course.power
        activity = moved.sum(-1) / count
        cost = error + goal.overshoot * beyond + goal.energy * energy + goal.activity * activity
        ends = np.zeros((*by_signal.shape[:-1], 1))
        by_signal = np.concatenate([ends, by_signal], -1) - np.concatenate([by_signal, ends], -1)
        by_power = np.full_like(outputs.power, goal.energy / course.power / outputs.power.shape[-1])
        by_signal = by_signal * (goal.activity / course.signal / count)
        return cost, by_output + goal.overshoot * more, by_signal, by_power

    def _error(self, e: Numbers) -> tuple[Any, Numbers]:
        span, clock = self.course.span, self.course.clock
        if self.goal.error == "ise":
            return (e**2).mean(-1) / span**2, 2.0 * e / e.shape[-1] / span**2
        timed = clock if self.goal.error == "itae" else np.ones_like(clock)
        weights = timed / timed.sum()
        size, slope = _smooth_size(e / span)
        return size @ weights, slope * weights / span

    def _overshoot(self, e: Numbers) -> tuple[Any, Numbers]:
        span, way = self.course.span, self.course.way
        count = max(int((way != 0.0).sum()), 1)
        beyond = np.maximum(e * way / span, 0.0)
        power = (beyond**ORDER).sum(-1, keepdims=True) / count
        some = power > 0.0
        mean = np.where(some, power, 1.0) ** (1.0 / ORDER)
        slope = np.where(some, beyond ** (ORDER - 1.0) * mean ** (1.0 - ORDER), 0.0)
        return np.where(some, mean, 0.0)[..., 0], slope * way / span / count


def _smooth_size(x: Numbers) -> tuple[Numbers, Numbers]:
    """Return |x| and its derivative, smooth around 0."""
    root = np.sqrt(x**2 + SMOOTH**2)
    return root - SMOOTH, x / root
