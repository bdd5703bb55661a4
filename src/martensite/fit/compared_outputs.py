"""What a fit compared, output by output: measured and modelled rows, and which of them it saw."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.mechanisms.base import Output
from martensite.fit.experiment import Experiment
from martensite.search.model_score import Score, score_model

if TYPE_CHECKING:
    from martensite.fit.fit import Fit

TRAINING, HELD_OUT = "training", "held-out"
COVERED = ("temperature", "stress")
"""What limits where fitted numbers hold."""


@dataclass(frozen=True)
class ComparedOutput:
    """One output of one record beside the fitted model, all in SI."""

    experiment: Experiment
    output: str
    description: Output
    """Unit, name and symbol of the output."""
    times: Any
    """(rows,) [s]"""
    measured: Any
    """(rows,); NaN where nothing was measured."""
    model: Any
    """(rows,), with the offset of the record."""
    used: Any
    """(rows,): True for what the fit saw."""

    @property
    def record(self) -> str:
        """Name of the record."""
        return self.experiment.name

    @property
    def column(self) -> str:
        """Column of the record that was compared."""
        return self.experiment.columns[self.output]

    @property
    def residuals(self) -> Any:
        """(rows,): modelled less measured; NaN where nothing was measured."""
        return self.model - self.measured

    @property
    def held(self) -> Any:
        """(rows,): True for what was measured but kept back."""
        return np.isfinite(self.measured) & ~self.used

    @property
    def missing(self) -> int:
        """Rows without a measured number."""
        return int(np.sum(~np.isfinite(self.measured)))

    def score(self) -> Iterator[Score]:
        """Errors of `training` rows, and of `held-out` ones, where there are any."""
        for part, rows in ((TRAINING, self.used), (HELD_OUT, self.held)):
            if rows.any():
                yield score_model(
                    self.times[rows],
                    self.measured[rows],
                    self.model[rows],
                    record=self.record,
                    output=self.output,
                    part=part,
                    unit=self.description.unit,
                )

    def rms(self, part: str) -> float:
        """Root-mean-square error of `training` or `held-out` rows; NaN if there are none."""
        return compute_rms([self], part)


def list_compared(fit: Fit) -> list[ComparedOutput]:
    """All records and outputs of a fit: those that were fitted, then those kept back."""
    return list(_iterate_compared(fit))


def compute_rms(rows: Iterable[ComparedOutput], part: str) -> float:
    """Root-mean-square error of all `training` or `held-out` rows together; NaN for none."""
    pieces = [one.residuals[one.used if part == TRAINING else one.held] for one in rows]
    errors = np.concatenate(pieces) if pieces else np.zeros(0)
    return math.sqrt(float(np.mean(errors**2))) if errors.size else math.nan


def _iterate_compared(fit: Fit) -> Iterator[ComparedOutput]:
    problem = fit.problem
    found = zip(problem.experiments, fit.evaluation.fitted, problem.used, strict=True)
    for one, fitted, used in found:
        yield from _split_outputs(one, fitted.model, used)
    for kept in fit.kept:
        yield from _split_outputs(kept.experiment, kept.model, np.zeros(kept.model.shape, bool))


def _split_outputs(one: Experiment, model: Any, used: Any) -> Iterator[ComparedOutput]:
    outputs = one.system.outputs()
    for k, name in enumerate(one.outputs):
        yield ComparedOutput(one, name, outputs[name], one.times, one.measured[:, k], model[:, k], used[:, k])


def find_covered_range(fit: Fit) -> dict[str, tuple[float, float]]:
    """Least and largest temperature [K] and stress [Pa] of the elements while they were fitted."""
    found: dict[str, tuple[float, float]] = {}
    for k, one in enumerate(fit.problem.experiments):
        system = fit.system(k)
        for name in COVERED:
            outputs = [system.label(port, name) for port in system.actuators()]
            runner = one.runner(fit.problem.step, outputs)
            run = runner.run_many(np.array([runner.compiled.values(system)]))[0]
            rows = run[fit.problem.used[k].any(axis=1)]
            ends = [float(rows.min()), float(rows.max()), *found.get(name, ())]
            found[name] = min(ends), max(ends)
    return found
