"""Steady states of a plant under constant signals, on a given branch.

With hysteresis, the steady state depends on history. The branch `heating` starts in equilibrium without signals.
The branch `cooling` starts in equilibrium under the highest signals. A plant continues along a branch only in the
same direction.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias, cast

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, ParameterError, SolveError, require_known
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.api import longest_step
from martensite.simulate.lanes import Lanes

Direction: TypeAlias = Literal["heating", "cooling"]
DIRECTIONS = ("heating", "cooling")
SIGNALS, ROUNDS = 25, 4
"""Signals per batch, and maximum refinements of the enclosing interval."""
SETTLED = 1e-9
"""Accepted change of a judged output in one more stretch, over its smallest relevant range."""
STRETCH, DOUBLINGS = 128, 12


@dataclass(frozen=True, eq=False)
class SteadyPoint:
    """Steady state of a plant."""

    system: AbstractSystem
    signals: tuple[float, ...]
    """Signals of all drives."""
    drive: str
    """Varied drive."""
    state: Numbers
    """All state variables, flat."""
    outputs: dict[str, float]
    direction: Direction

    @property
    def signal(self) -> float:
        """Return the signal of the varied drive."""
        return self.signals[[one.name for one in self.system.drives()].index(self.drive)]


def find_operating_point(
    system: AbstractSystem,
    signal: float,
    *,
    direction: Direction = "heating",
    high: float | None = None,
    drive: str | None = None,
    others: Mapping[str, float] | None = None,
) -> SteadyPoint:
    """Find the steady state of a system under a constant signal.

    Args:
        system: a plant, or a bench without a controller.
        signal: signal of the drive, in the unit of its source.
        direction: branch of the approach.
        high: signal of the previous steady state, for `cooling`.
        drive: varied drive; by default the first.
        others: constant signals of other drives; by default 0.

    Raises:
        InputError: a name does not fit, or `high` is missing.
        SolveError: the system does not reach a steady state.
    """
    rest = _RestingLanes(system, drive, others, direction, high)
    row = np.array([float(signal)])
    return rest.point(rest.settle(row), row, 0)


def find_operating_level(
    system: AbstractSystem,
    level: float,
    output: str,
    low: float,
    high: float,
    *,
    direction: Direction = "heating",
    drive: str | None = None,
    others: Mapping[str, float] | None = None,
) -> SteadyPoint:
    """Find the steady state with an output at a level, on a branch between two signals.

    Args:
        system: a plant, or a bench without a controller.
        level: target of the output, in SI.
        output: name of the output.
        low: minimum signal.
        high: maximum signal, and signal of the previous steady state for `cooling`.
        direction: branch of the approach.
        drive: varied drive; by default the first.
        others: constant signals of other drives; by default 0.

    Raises:
        InputError: a name does not fit.
        ParameterError: no signal between the bounds reaches the level.
        SolveError: the system does not reach a steady state.
    """
    rest, names = _RestingLanes(system, drive, others, direction, high), list(system.outputs())
    require_known("output", output, names)
    place, ends = names.index(output), (low, high)
    for number in range(ROUNDS):
        row = np.linspace(*ends, SIGNALS)
        lanes = rest.settle(row)
        beyond = lanes.observe(rest.signals(row))[place] - level
        turns = np.flatnonzero(beyond[:-1] * beyond[1:] <= 0.0)
        if not len(turns):
            reached = beyond + level
            raise ParameterError(
                f"`{output}` rests between {reached.min():.6g} and {reached.max():.6g} under "
                f"signals from {low:g} to {high:g}, and never at {level:.6g}."
            )
        k = int(turns[0])
        if number == ROUNDS - 1:
            return rest.point(lanes, row, k if abs(beyond[k]) < abs(beyond[k + 1]) else k + 1)
        ends = (float(row[k]), float(row[k + 1]))
    raise SolveError(f"No signal was found at which `{output}` rests at {level:.6g}.")


class _RestingLanes:
    """Batch of steady states on a branch, with one varied drive."""

    def __init__(
        self,
        system: AbstractSystem,
        drive: str | None,
        others: Mapping[str, float] | None,
        direction: Direction,
        high: float | None,
    ) -> None:
        names = [one.name for one in system.drives()]
        if not names:
            raise InputError("A system without drives has no operating point to choose.")
        require_known("direction", direction, DIRECTIONS)
        if direction == "cooling" and high is None:
            raise InputError("The cooling branch needs `high`, the signal under which it begins.")
        self.system, self.drive = system, drive or names[0]
        self.direction: Direction = direction
        for name in (self.drive, *(others or {})):
            require_known("drive", name, names)
        self._base = np.array([float((others or {}).get(name, 0.0)) for name in names])
        self._place = names.index(self.drive)
        self._before = high if direction == "cooling" else None

    def signals(self, row: Numbers) -> Numbers:
        """Return the signals of all drives, shape (drives, lanes)."""
        table = np.repeat(self._base[:, None], len(row), axis=1)
        table[self._place] = row
        return table

    def settle(self, row: Numbers) -> Lanes:
        """Return the steady states under the signals of a row."""
        lanes = Lanes(self.system, len(row))
        lanes.reset(self._base[:, None])
        if self._before is not None:
            settle_lanes(lanes, self.signals(np.full(len(row), self._before)))
        settle_lanes(lanes, self.signals(row))
        return lanes

    def point(self, lanes: Lanes, row: Numbers, lane: int) -> SteadyPoint:
        """Return the steady state of one batch element under the signals of a row."""
        failed = lanes.status[lane]
        if failed.failed:
            raise SolveError(f"The plant failed before its steady state. {failed.sentence}")
        signals = self.signals(row)
        outputs = cast("list[float]", lanes.observe(signals)[:, lane].tolist())
        return SteadyPoint(
            self.system,
            tuple(signals[:, lane].tolist()),
            self.drive,
            lanes.state[:, lane].copy(),
            dict(zip(lanes.names, outputs, strict=True)),
            self.direction,
        )


def settle_lanes(lanes: Lanes, signals: Numbers, doublings: int = DOUBLINGS, settled: float = SETTLED) -> None:
    """Hold signals, (drives, batch), in doubling stretches until judged outputs settle.

    Raises:
        SolveError: the outputs do not settle in time.
    """
    system, names = lanes.system, lanes.names
    judged = system.convergence_scales()
    places = [names.index(name) for name in judged]
    sizes = np.array(list(judged.values()))[:, None]
    dt = system.sample_time() or longest_step(system)
    last, stretch = lanes.observe(signals)[places], STRETCH
    for _ in range(doublings):
        signal_rows = np.broadcast_to(signals, (stretch, *signals.shape))
        lanes.advance(signal_rows, dt, shown=False)
        now = lanes.observe(signals)[places]
        if np.max(np.abs(now - last) / sizes, initial=0.0) <= settled:
            return
        last, stretch = now, stretch * 2
    raise SolveError(
        f"The system does not reach a steady state within {stretch * dt:.3g} s under held drives: it vibrates, turns "
        "or is very slow."
    )
