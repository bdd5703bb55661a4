"""Track of a result, computed on demand, and error bounds of measures.

The bound of a measure is the difference between the last two passes times `ERROR_SAFETY`; the earlier pass is
repeated. The bound is at least the maximum of
- the change due to errors of all values within the accuracy of the run. These are fractions of the column range, or
of the value for integrals if less. A crossing or peak may move to another of similar height;
- the change without every second point, for measures of the curve between steps;
- the change due to curvature (`martensite.simulate.chords`), for extremes and measures of the curve;
- the quadrature error, for integrals.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.status import Status
from martensite.signals.base import AbstractWaveform
from martensite.simulate.accuracy import ERROR_SAFETY, FINER, FLOOR, LOCAL, RunEngine, bound_error
from martensite.simulate.envelope import cut_outside
from martensite.simulate.marching import MarchPlan, MarchResult
from martensite.simulate.measures.base import AbstractMeasure
from martensite.simulate.measures.run_table import Numbers, RunTable, tabulate_track
from martensite.simulate.recorded_track import Observe, build_long_track, build_track, tabulate_tones
from martensite.simulate.restarts import Relay
from martensite.simulate.track import Track, track_rows

ROUNDING = 1e-11
"""Smallest reported bound, as a fraction of a measure or of its values."""

LEAST_RANGE = 0.01
"""Smallest range of outputs without error control, as a fraction of their largest value."""


def assemble_track(
    plan: MarchPlan,
    record: Any,
    outputs: Sequence[int],
    observe: Observe,
    waveforms: Sequence[Sequence[AbstractWaveform]],
) -> Track:
    """Compute the track of runs with recorded steps.

    Args:
        plan: plan of the runs, with their tolerance.
        record: rows of all runs, grouped by run and in time order.
        outputs: indices of the outputs.
        observe: function that computes these outputs.
        waveforms: waveforms of every run, or of all runs in one row.

    Returns:
        The track, with the outputs in SI.
    """
    compiled, tones = plan.compiled, tabulate_tones(waveforms)
    swinging = np.array(compiled.swinging, np.bool_)[list(outputs)]
    shape = compiled.drives, tones, swinging, observe, plan.tolerance
    return build_long_track(np.asarray(record, float), lambda some: build_track(some, *shape))


class AbstractTrace(ABC):
    """Track computation of a single run."""

    @abstractmethod
    def compute_track(self) -> Track:
        """Return the outputs of the run at its accepted steps."""

    def bound_measure(self, one: AbstractMeasure, track: Track) -> float | None:
        """Return the error bound of a measure of the track, in its unit; None if unknown."""
        return None


@dataclass(frozen=True, eq=False)
class RowsTrace(AbstractTrace):
    """Track of a run on given steps from stored step ends."""

    times: Sequence[float]
    """[s]"""
    rows: Any
    """Outputs in SI, in system order."""
    outputs: int

    def compute_track(self) -> Track:
        """Return the rows as a track."""
        return track_rows(self.times, self.rows, self.outputs)


@dataclass(frozen=True, eq=False)
class RunTrace(AbstractTrace):
    """Track of a run with step size control or a longest step."""

    system: AbstractSystem
    engine: RunEngine
    plan: MarchPlan
    last_pass: MarchResult
    relay: Relay
    """Relay of the passes of the run."""

    def compute_track(self) -> Track:
        """Return the outputs of the last pass."""
        return self._observe(self.last_pass)

    def _observe(self, run: MarchResult) -> Track:
        plan, outputs = self.plan, range(len(self.system.outputs()))
        observe = self.engine.observe(plan, outputs, run.runtime)
        track = assemble_track(plan, run.record, outputs, observe, [plan.waveforms])
        return cut_outside(self.system, track) if run.status is Status.OUT_OF_ENVELOPE else track

    @cached_property
    def _earlier(self) -> Track:
        """Return the outputs of the second-last pass, which is repeated."""
        plan = self.plan
        local = LOCAL[plan.order] * plan.tolerance / FINER ** (len(self.relay.passes) - 2)
        again = replace(self.relay, passes=[])
        before = again(plan._replace(tolerance=local, times=[plan.times[0], plan.times[-1]]))
        return self._observe(before)

    def bound_measure(self, one: AbstractMeasure, track: Track) -> float | None:
        """Return the bound from the second-last pass; None for given steps and incomplete runs."""
        plan, outputs = self.plan, list(self.system.outputs())
        if plan.step is not None or self.last_pass.status.failed:
            return None
        names = one.columns(self.system)
        places = [outputs.index(name) for name in names]
        own = tabulate_track(track, places, 1, one.follows_curve)
        other = tabulate_track(self._earlier, places, 1, one.follows_curve)
        value = float(one.value(own)[0])
        apart = abs(value - float(one.value(other)[0]))
        thinned = [own.thin(first) for first in (0, 1)] if one.follows_curve else []
        curve_error = max((abs(value - float(one.value(few)[0])) for few in thinned), default=0.0)
        bent = tabulate_track(track.bend(), places, 1, one.follows_curve)
        curve_error = max(curve_error, abs(value - float(one.value(bent)[0])))
        kelvin = np.array([self.system.outputs()[name].unit == "K" for name in names], float)
        off = one.spread(own, self._allow_values(one, own, other, bent))
        if one.averages:
            read = np.abs(one.derivatives(own)[:, :, 0])
            weights = np.where(own.weights[:, 0] > 0.0, own.weights[:, 0], np.inf)
            curve_error = float((read / weights).max(axis=1) @ track.choose(places).bound_quadrature())
        total = max(ERROR_SAFETY * apart, off, curve_error, ROUNDING * abs(value)) + one.spread(
            own, self.last_pass.ripple * kelvin
        )
        return total if np.isfinite(total) else None

    def _allow_values(self, one: AbstractMeasure, own: RunTable, other: RunTable, bent: RunTable) -> Numbers:
        """Return the error bounds of the values that a measure reads, (columns,).

        Args:
            one: the measure.
            own: table of the last pass.
            other: table of the previous pass.
            bent: table of the last pass with the largest possible curvature.
        """
        least = dict(self.plan.compiled.convergence_scales)
        nothing = LEAST_RANGE * np.abs(own.values[:, :, 0]).max(axis=1)
        scales = np.array(
            [max(np.ptp(own.values[k]), least.get(n, nothing[k])) for k, n in enumerate(one.columns(self.system))]
        )
        share = max(FLOOR * self.plan.tolerance, bound_error(self.plan.compiled, self.last_pass))
        values = share * scales + ROUNDING * np.abs(own.values[:, :, 0]).max(axis=1)
        if one.seeks_turn:
            values = np.maximum(values, np.maximum(ERROR_SAFETY * part_extremes(own, other), part_extremes(own, bent)))
        return values


def part_extremes(one: RunTable, other: RunTable) -> Numbers:
    """Return the differences of extremes between two tables of a run, (columns,)."""
    highest, lowest = (
        np.abs(find(one)[:, 0] - find(other)[:, 0]) for find in (RunTable.find_highest, RunTable.find_lowest)
    )
    return np.maximum(highest, lowest)
