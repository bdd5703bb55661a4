"""Controllers tuned on models, and the closed loops of models and bench."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from martensite.control.tuning.closed_loop import ControlledModel, Trajectory
from martensite.control.tuning.measures import StepResponse, measure_steps
from martensite.control.tuning.tuning import TunedGains, tune_model
from martensite.identify.chains.chain import Chain
from martensite.studies.hammerstein_wiener import loop, models
from martensite.studies.hammerstein_wiener.bench import INTERVAL
from martensite.studies.hammerstein_wiener.comparisons import nrmse_fit

LOOPS = ("stage 2, 12 wavelets", "stage 2, not anchored", "stage 2, hysteresis", "whole")
"""Models for tuning: second stages after stage 1, and the whole one."""


@dataclass(frozen=True, eq=False)
class LoopPair:
    """A model and the bench under the same gains."""

    tuned: TunedGains
    model: Trajectory
    bench: Trajectory

    @property
    def likeness(self) -> float:
        """Return the fit of the model trajectory to the bench [%]."""
        return nrmse_fit(self.bench.output, self.model.output)

    def responses(self) -> list[tuple[StepResponse, StepResponse]]:
        """Return the step responses of model and bench."""
        rows = (measure_steps(r.reference, r.output, INTERVAL) for r in (self.model, self.bench))
        return list(zip(*rows, strict=True))


@dataclass(frozen=True, eq=False)
class Sines:
    """Tracking of a sine; RMS values after the first 20 s."""

    model: Trajectory
    bench: Trajectory

    @property
    def tracking(self) -> float:
        """Return the tracking error of the bench [m]."""
        return _counted_rms(self.bench.reference - self.bench.output)

    @property
    def branches(self) -> tuple[float, float]:
        """Return the errors on rising (heated) and on falling reference [m]."""
        error = self.bench.reference - self.bench.output
        rising = np.gradient(self.bench.reference) >= 0.0
        return _counted_rms(error, rising), _counted_rms(error, ~rising)

    @property
    def apart(self) -> float:
        """Return the difference between bench and model [m]."""
        return _counted_rms(self.bench.output - self.model.output)

    @property
    def apart_heated(self) -> float:
        """Return the difference between bench and model while the controller heats the bench [m]."""
        return _counted_rms(self.bench.output - self.model.output, self.bench.signal > 0.0)

    @property
    def apart_unheated(self) -> float:
        """Return the difference between bench and model at zero duty cycle [m]."""
        return _counted_rms(self.bench.output - self.model.output, self.bench.signal <= 0.0)


def _counted_rms(error: np.ndarray, where: np.ndarray | None = None) -> float:
    """Return the RMS error of the scored samples, optionally where a flag holds."""
    first = round(loop.SINE_SCORED / INTERVAL)
    chosen = error[first:] if where is None else error[first:][where[first:]]
    return float(np.sqrt(np.mean(chosen**2)))


@cache
def build_controlled(name: str) -> ControlledModel:
    """Return a model of the study with its position in a loop."""
    chain: Chain = models.estimate_recipe("whole") if name == "whole" else models.join_stages(name)
    return ControlledModel(chain)


@cache
def find_gains(name: str) -> TunedGains:
    """Return the gains tuned on a model."""
    return tune_model(build_controlled(name), loop.TUNING)


@cache
def compare_steps(name: str) -> LoopPair:
    """Return model and bench on a staircase."""
    reference, tuned = loop.step_reference(), find_gains(name)
    return LoopPair(
        tuned, build_controlled(name).run(tuned.gains, reference), loop.run_controlled(tuned.gains, reference)
    )


@cache
def compare_sines(name: str) -> Sines:
    """Return model and bench on a sine."""
    reference, gains = loop.sine_reference(), find_gains(name).gains
    return Sines(build_controlled(name).run(gains, reference), loop.run_controlled(gains, reference))
