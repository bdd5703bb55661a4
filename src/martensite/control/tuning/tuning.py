"""PID gains from a model alone: the least cost of a reference made of steps.

    cost = mean|e| + overshoot + 2 mean|Δu| + 10⁻⁴ K_p + 10⁻⁶ K_d

with errors and overshoot in a unit of the output and changes Δu per sample in a unit of the signal (`CostScale`).
Overshoot is the largest excess of any step. The method of Nelder and Mead searches the logarithms of the gains from
several starts. The plant itself is not used, so that it can validate the model.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import minimize

from martensite.base.errors import ParameterError
from martensite.control.controllers.pid import Gains
from martensite.control.tuning.closed_loop import ControlledModel, Trajectory, compute_logarithms
from martensite.control.tuning.measures import StepResponse, build_steps, measure_steps
from martensite.signals.sampling.sampled import Numbers

STARTS = ((10.0, 0.01, 0.1), (50.0, 0.05, 100.0), (100.0, 0.2, 1000.0), (5.0, 0.001, 1000.0))


@dataclass(frozen=True)
class CostScale:
    """Units of the cost, in SI."""

    output: float = 1e-3
    signal: float = 0.01


@dataclass(frozen=True)
class CostWeights:
    """Weights of the parts of the cost; the weight of the error is 1."""

    overshoot: float = 1.0
    activity: float = 2.0
    proportional: float = 1e-4
    derivative: float = 1e-6


@dataclass(frozen=True)
class ModelTuning:
    """Settings of the search."""

    levels: tuple[tuple[float, float], ...]
    """Reference: levels in the unit of the output, and times [s]."""
    scale: CostScale = field(default_factory=CostScale)
    weights: CostWeights = field(default_factory=CostWeights)
    starts: Sequence[tuple[float, float, float]] = STARTS
    evaluations: int = 600
    beyond_data: bool = False
    """True to allow steady states outside the records of the model."""


@dataclass(frozen=True, eq=False)
class TunedGains:
    """Tuned gains, and the run of the model with them."""

    gains: Gains
    """Gains per sample, in signal per unit of the output."""
    cost: float
    trajectory: Trajectory
    responses: tuple[StepResponse, ...]
    costs: tuple[float, ...]
    evaluations: int
    scale: CostScale

    def scale_gains(self) -> Gains:
        """Return the gains in the units of the cost, such as percent per millimetre."""
        return Gains(*(gain * self.scale.output / self.scale.signal for gain in self.gains))

    def rows(self) -> list[tuple[str, float, str]]:
        """Return name, value and unit of all results."""
        rows = [(name, float(gain), "1") for name, gain in self.gains._asdict().items()]
        for k, step in enumerate(self.responses, start=1):
            rows += [
                (f"step {k} rise", step.rise, "s"),
                (f"step {k} settling", step.settling, "s"),
                (f"step {k} overshoot", step.overshoot, "1"),
                (f"step {k} error", step.error, "unit of the output"),
            ]
        return rows


def compute_cost(run: Trajectory, gains: Gains, tuning: ModelTuning) -> float:
    """Return the cost of a run; infinite for a run that is not finite."""
    if not np.all(np.isfinite(run.output)):
        return np.inf
    scale, weights = tuning.scale, tuning.weights
    steps = measure_steps(run.reference, run.output, run.interval)
    beyond = max((one.overshoot * abs(one.after - one.before) for one in steps), default=0.0)
    unit = scale.output / scale.signal
    error = float(np.mean(np.abs(run.reference - run.output))) / scale.output
    activity = float(np.mean(np.abs(np.diff(run.signal)))) / scale.signal
    return (
        error
        + weights.overshoot * beyond / scale.output
        + weights.activity * activity
        + weights.proportional * unit * abs(gains.Kp)
        + weights.derivative * unit * abs(gains.Kd)
    )


def tune_model(
    model: ControlledModel, tuning: ModelTuning, watch: Callable[[str, float], None] | None = None
) -> TunedGains:
    """Search the gains of least cost on a model.

    Args:
        model: model in its loop.
        tuning: reference, cost and starts.
        watch: called with a sentence and the completed fraction.

    Raises:
        ParameterError: starts are missing, no start gives a finite run, or steady states lie outside the records
            (`rest_check.check_static_curve`).
    """
    if not tuning.beyond_data:
        model.check_static_curve([level for level, _ in tuning.levels])
    reference = build_steps(tuning.levels, model.chain.interval)
    unit = tuning.scale.signal / tuning.scale.output
    count = 0

    def value(theta: Numbers) -> float:
        nonlocal count
        count += 1
        gains = _build_gains(theta, model)
        return compute_cost(model.run(gains, reference), gains, tuning)

    ends: list[tuple[float, Numbers]] = []
    for k, start in enumerate(tuning.starts):
        begin = compute_logarithms(Gains(*(unit * gain for gain in start)))
        ends.append(_search_simplex(value, begin, max(tuning.evaluations // len(tuning.starts), 1)))
        if watch is not None:
            watch(f"start {k + 1} of {len(tuning.starts)}", (k + 1) / len(tuning.starts))
    ends.sort(key=lambda end: end[0])
    if not ends or not np.isfinite(ends[0][0]):
        raise ParameterError("No start of the tuning gives a run of the model that is finite.")
    gains = _build_gains(ends[0][1], model)
    run = model.run(gains, reference)
    responses = tuple(measure_steps(reference, run.output, run.interval))
    return TunedGains(gains, ends[0][0], run, responses, tuple(e[0] for e in ends), count, tuning.scale)


def _build_gains(theta: Numbers, model: ControlledModel) -> Gains:
    return Gains(*(model.block.sign * float(gain) for gain in np.exp(np.clip(theta, -60, 60))))


def _search_simplex(value: Callable[[Numbers], float], begin: Numbers, evaluations: int) -> tuple[float, Numbers]:
    simplex = np.vstack([begin, begin + np.eye(len(begin))])
    with np.errstate(all="ignore"):
        result = minimize(
            value,
            begin,
            method="Nelder-Mead",
            options={"maxfev": evaluations, "initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-6},
        )
    return float(result.fun), np.asarray(result.x)
