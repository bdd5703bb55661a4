"""Comparison of a loop before and after tuning: same plants, same noise, one measure of the error.

    rms = √(mean over plants of rms²)        itae, iae = mean over plants

The measure is the error of the goal of the search (`rms` for `ise`), else `rms`. A failed run has an infinite error. A
result is worse if its error is larger than before.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from martensite.base.errors import InputError
from martensite.base.formats import choose_difference_unit, typeset_unit
from martensite.control.tuning.goals import Course, Numbers
from martensite.control.tuning.loop_runs import LoopOutputs, LoopRuns
from martensite.control.tuning.measures import UNITS, compute_itae
from martensite.control.tuning.plant_spread import Plants

MEASURES = {"itae": "itae", "iae": "iae", "ise": "rms"}
"""Measure of the comparison by error of the goal."""
ROUNDING = 1e-9


class JudgedLoop(NamedTuple):
    """A loop in a comparison."""

    runs: LoopRuns
    values: Mapping[str, float]
    """Changed parameters by path."""


@dataclass(frozen=True, eq=False)
class TuningJudgement:
    """Errors of a loop on plants, before and after a tuning."""

    measure: str
    """Measure: rms, itae or iae."""
    unit: str
    before: Numbers
    """Error of every plant, in SI."""
    after: Numbers
    has_drawn_plants: bool
    """True for drawn plants, False for the nominal plant alone."""

    @property
    def errors(self) -> tuple[float, float]:
        """Return the error over all plants, before and after, in SI."""
        if self.measure == "rms":
            return float(np.sqrt(np.mean(self.before**2))), float(np.sqrt(np.mean(self.after**2)))
        return float(self.before.mean()), float(self.after.mean())

    @property
    def worse(self) -> bool:
        """Return True if the error is larger than before."""
        before, after = self.errors
        return after > before * (1.0 + ROUNDING)

    @property
    def word(self) -> str:
        """Return the verdict as two or three words."""
        before, after = self.errors
        return "Worse than before" if self.worse else "As before" if after >= before else "Better than before"

    def describe(self) -> str:
        """Describe both errors and the plants, such as `rms 0.3 mm instead of 0.7 mm on 16 plants, better on 15`."""
        readable_unit, factor = choose_difference_unit(self.unit)
        unit = typeset_unit(UNITS[self.measure].format(readable_unit))
        before, after = (f"{x / factor:.3g} {unit}" if np.isfinite(x) else "a run that fails" for x in self.errors)
        better = int((self.after < self.before).sum())
        where = (
            f"{len(self.after)} plants, better on {better}" if self.has_drawn_plants else "the plant of the scenario"
        )
        name = self.measure if self.measure == "rms" else self.measure.upper()
        return f"{name} {after} instead of {before}{self._write_ratio()} on {where}"

    def _write_ratio(self) -> str:
        before, after = self.errors
        return f" ({after / before:.2g} times)" if self.worse and 0.0 < before and np.isfinite(after) else ""

    def to_dict(self) -> dict[str, float | int | str | bool]:
        """Return all results by name, in SI."""
        before, after = self.errors
        ratios = self.after / self.before
        return {
            "worse": self.worse,
            "measure": self.measure,
            "before": before,
            "after": after,
            "plants": len(self.after),
            "ratio_median": float(np.median(ratios)),
            "ratio_worst": float(ratios.max()),
            "share_improved": float((self.after < self.before).mean()),
        }

    def require_better(self, *, anyway: bool = False) -> None:
        """Raise `InputError` for a worse result unless `anyway` is True."""
        if self.worse and not anyway:
            raise InputError(f"{self.word}: {self.describe()}; not saved. Pass `anyway=True` to save it.")


def judge_loops(
    before: JudgedLoop, after: JudgedLoop, plants: Plants | None = None, measure: str = "rms"
) -> TuningJudgement:
    """Run a loop before and after a tuning on the same plants, and compare the errors.

    Args:
        before: present loop.
        after: tuned loop on the same plant.
        plants: plants of the comparison; default: the nominal plant.
        measure: rms, itae or iae.

    Raises:
        ParameterError: the reference stays where the output begins.
    """
    rows = [_run_plants(one, plants) for one in (before, after)]
    period = before.runs.bench.period
    finite = (row.one(int(k)) for row in rows for k in np.flatnonzero(np.isfinite(row.output).all(-1)))
    first = next(finite, None)
    course = None if first is None else Course(first, period)
    unit = before.runs.bench.outputs()[before.runs.output].unit
    errors = [_measure_errors(row, course, measure, period) for row in rows]
    return TuningJudgement(measure, unit, errors[0], errors[1], plants is not None)


def _run_plants(one: JudgedLoop, plants: Plants | None) -> LoopOutputs:
    plant_values = {} if plants is None else plants.values
    return one.runs.run(one.runs.table({**plant_values, **one.values}, 1 if plants is None else plants.count))


def _measure_errors(outputs: LoopOutputs, course: Course | None, measure: str, period: float) -> Numbers:
    off = np.abs(outputs.reference - outputs.output)
    if course is None:
        return np.full(len(off), np.inf)
    if measure == "itae":
        errors = np.asarray(compute_itae(outputs, course))
    else:
        errors = off[:, 1:].sum(-1) * period if measure == "iae" else np.sqrt((off**2).mean(-1))
    return np.where(np.isfinite(errors), errors, np.inf)
