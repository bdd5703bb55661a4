"""Outputs of a system under a separate signal in every lane, for analyses of speed.

A system in discrete time advances from sample to sample; an output belongs to the signal of the same sample. A plant in
continuous time advances in equal steps with signals held at mid-step; an output is at the end of its step.
"""

from __future__ import annotations

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
    """Lanes of a system with one drive and one output."""

    def __init__(
        self,
        system: AbstractSystem,
        count: int,
        drive: str | None = None,
        output: str | None = None,
        values: Mapping[str, Any] | None = None,
        native: bool | None = None,
    ) -> None:
        """Prepare the lanes of a plant or bench; `reset` brings them to the steady state.

        The drive is by default the first, and all other signals are 0. The output is by default the first coordinate of
        the mechanism. `values` are parameters by path, one value per lane.

        Raises:
            InputError: a name is unknown.
        """
        names = [one.name for one in system.drives()]
        if not names:
            raise InputError("A system without drives cannot be driven.")
        self.drive = drive or names[0]
        require_known("drive", self.drive, names)
        self.output = output or next(iter(system.mechanism.outputs()))
        require_known("output", self.output, system.outputs())
        self.system, self.count = system, count
        self.lanes = Lanes(system, count, values, native)
        self._drive = names.index(self.drive)
        self._ahead = system.drives()[self._drive].ahead
        self._output = self.lanes.names.index(self.output)

    @property
    def interval(self) -> float:
        """Return the sample time of a system in discrete time [s], else 0."""
        return self.system.sample_time()

    def step(self, longest: float) -> float:
        """Return a step length [s] that resolves the plant and is at most `longest`."""
        return self.interval or min(longest, longest_step(self.system))

    def reset(self, levels: Any) -> Numbers:
        """Bring all lanes to the steady state under levels, (lanes,) or scalar, and return the output."""
        signals = self._spread(np.broadcast_to(np.asarray(levels, float), self.count)[None])[0]
        self.lanes.reset(signals)
        return self.lanes.observe(signals)[self._output]

    def run(self, levels: Any, dt: float) -> Numbers:
        """Return the output at the end of every step.

        Args:
            levels: signals at the samples of a system in discrete time, (samples + 1, lanes), else at mid-step, (steps,
                lanes).
            dt: length of a step [s].

        Raises:
            SolveError: a lane failed.
        """
        if self.interval:
            rows = self._sample_outputs(levels, dt)
        else:
            rows = self.lanes.advance(self._spread(levels), dt)[:, self._output]
        if not ((self.lanes.worst[0] <= SOLVED).all() and np.isfinite(rows).all()):
            worst = next(one for one in self.lanes.status if one.failed)
            raise SolveError(f"A lane of `{self.drive}` failed. {worst.sentence}")
        return rows

    def _sample_outputs(self, levels: Numbers, dt: float) -> Numbers:
        """Return the outputs at samples; a drive that is read ahead acts at the end of a sample."""
        signals = self._spread(levels)
        if self._ahead:
            return self.lanes.advance(signals[1:], dt)[:, self._output]
        outputs = np.empty((len(signals) - 1, self.count))
        for k, now in enumerate(signals[:-1]):
            self.lanes.advance(now[None], dt, shown=False)
            outputs[k] = self.lanes.observe(signals[k + 1])[self._output]
        return outputs

    def _spread(self, levels: Numbers) -> Numbers:
        """Return the signals of all drives, shape (steps, drives, lanes)."""
        signals = np.zeros((len(levels), len(self.lanes.drives), self.count))
        signals[:, self._drive] = levels
        return signals


def require_positive(name: str, values: Any, unit: str) -> Numbers:
    """Return values as an array; `InputError` if it is empty or a value is not above 0."""
    numbers = np.atleast_1d(np.asarray(values, float))
    if not numbers.size or not (np.isfinite(numbers) & (numbers > 0.0)).all():
        raise InputError(f"`{name}` must be numbers above 0 {unit}.")
    return numbers
