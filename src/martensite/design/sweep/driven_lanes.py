"""Outputs of a system under a separate signal in every lane, the basis of analyses of speed.

A system in discrete time advances from sample to sample; outputs belong to the signal of the same sample. A plant in
continuous time advances in equal steps with signals held at mid-step; outputs are at the end of a step, under the
signal of that step.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, SolveError, require_known
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.api import longest_step
from martensite.simulate.lanes import Lanes
from martensite.simulate.march import SOLVED


class DrivenLanes:
    """Lanes of a system, one drive and one output of which matter."""

    def __init__(
        self,
        system: AbstractSystem,
        count: int,
        drive: str | None = None,
        output: str | None = None,
        values: Mapping[str, Any] | None = None,
        native: bool | None = None,
    ) -> None:
        """Lanes at rest come with `reset`, of a plant, or a bench, whose controllers then close their loops.

        The signal of one drive is given, by default of the first, those of all others are 0; what is looked at is by
        default the first coordinate of the mechanism. Values are parameters by path that differ from lane to lane.

        Raises:
            InputError: a name does not fit.
        """
        names = [one.name for one in system.drives()]
        if not names:
            raise InputError("A system without drives cannot be driven.")
        self.drive = drive or names[0]
        require_known("drive", self.drive, names)
        known = system.outputs()
        self.output = output or next(iter(system.mechanism.outputs()))
        require_known("output", self.output, known)
        self.system, self.count = system, count
        self.lanes = Lanes(system, count, values, native)
        self._drive = names.index(self.drive)
        self._ahead = system.drives()[self._drive].ahead
        self._output = self.lanes.names.index(self.output)

    @property
    def interval(self) -> float:
        """Sample time of a system in discrete time [s], else 0."""
        return self.system.sample_time()

    def step(self, longest: float) -> float:
        """Return the length of a step [s] that resolves the plant and is at most `longest`."""
        return self.interval or min(longest, longest_step(self.system))

    def reset(self, levels: Any) -> Numbers:
        """Return all lanes at rest under first levels, which spread to (lanes,); the output there."""
        signals = self._spread(np.broadcast_to(np.asarray(levels, float), self.count)[None])[0]
        self.lanes.reset(signals)
        return self.lanes.observe(signals)[self._output]

    def run(self, levels: Any, dt: float) -> Numbers:
        """Return the output at the end of every step.

        Args:
            levels: of a system in discrete time at samples, (samples + 1, lanes), from now on; of
                others in the middle of steps, (steps, lanes).
            dt: length of a step [s].

        Raises:
            SolveError: a lane failed.
        """
        if self.interval:
            rows = self._sampled(levels, dt)
        else:
            rows = self.lanes.advance(self._spread(levels), dt)[:, self._output]
        if not ((self.lanes.worst[0] <= SOLVED).all() and np.isfinite(rows).all()):
            worst = next(one for one in self.lanes.status if one.failed)
            raise SolveError(f"A lane of `{self.drive}` failed. {worst.sentence}")
        return rows

    def _sampled(self, levels: Numbers, dt: float) -> Numbers:
        """Return a drive that is read ahead counts at the end of a sample, others at its start."""
        signals = self._spread(levels)
        if self._ahead:
            return self.lanes.advance(signals[1:], dt)[:, self._output]
        found = np.empty((len(signals) - 1, self.count))
        for k, now in enumerate(signals[:-1]):
            self.lanes.advance(now[None], dt, shown=False)
            found[k] = self.lanes.observe(signals[k + 1])[self._output]
        return found

    def _spread(self, levels: Numbers) -> Numbers:
        """Return the signals of all drives, shape (steps, drives, lanes)."""
        found = np.zeros((len(levels), len(self.lanes.drives), self.count))
        found[:, self._drive] = levels
        return found


def require_positive(name: str, values: Any, unit: str) -> Numbers:
    """Return the numbers above 0 as an array; `InputError` if there are none, or one is not above 0."""
    found = np.atleast_1d(np.asarray(values, float))
    if not found.size or not all(math.isfinite(x) and x > 0.0 for x in found.ravel()):
        raise InputError(f"`{name}` must be numbers above 0 {unit}.")
    return found
