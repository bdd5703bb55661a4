"""Steady states of a plant under constant signals, on a given branch.

With hysteresis one signal has two positions of rest, and all between them: what was before
decides. `heating` comes from rest without any signal, `cooling` from having rested under the
highest one. On a branch the plant goes on along it only in the same direction.
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
"""Signals tried side by side, and how often between the two that enclose the level."""
SETTLED = 1e-9
"""Change of a judged output in one more stretch, over the least range that counts."""
STRETCH, DOUBLINGS = 128, 12


@dataclass(frozen=True, eq=False)
class SteadyPoint:
    """A plant at rest."""

    system: AbstractSystem
    signals: tuple[float, ...]
    """Signals of all drives."""
    drive: str
    """The one that is varied."""
    state: Numbers
    """All state variables, flat."""
    outputs: dict[str, float]
    direction: Direction

    @property
    def signal(self) -> float:
        """Return the signal of the drive that is varied."""
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
        signal: of its drive, in the unit of its source.
        direction: by which branch it gets there.
        high: signal under which it rested before; needed for `cooling`.
        drive: which one; the first if not named.
        others: constant signals of other drives; what is not named gets 0.

    Raises:
        InputError: a name does not fit, or `high` is missing.
        SolveError: the system does not come to rest.
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
        level: of the output, in SI.
        output: which one.
        low: least signal.
        high: largest signal, under which it has rested before for `cooling`.
        direction: by which branch it gets there.
        drive: which one; the first if not named.
        others: constant signals of other drives; what is not named gets 0.

    Raises:
        InputError: a name does not fit.
        ParameterError: no signal between the two leads there.
        SolveError: the system does not come to rest.
    """
    rest, known = _RestingLanes(system, drive, others, direction, high), list(system.outputs())
    require_known("output", output, known)
    place, ends = known.index(output), (low, high)
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
    """Lanes of a system that come to rest on a branch, one drive of which is varied."""

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
        """Return the signals of all drives in all batch elements, shape (drives, batch elements)."""
        table = np.repeat(self._base[:, None], len(row), axis=1)
        table[self._place] = row
        return table

    def settle(self, row: Numbers) -> Lanes:
        """Return the batch elements at rest under the signals of a row."""
        lanes = Lanes(self.system, len(row))
        lanes.reset(self._base[:, None])
        if self._before is not None:
            settle_lanes(lanes, self.signals(np.full(len(row), self._before)))
        settle_lanes(lanes, self.signals(row))
        return lanes

    def point(self, lanes: Lanes, row: Numbers, lane: int) -> SteadyPoint:
        """Return the state of one batch element under the signals of a row."""
        failed = lanes.status[lane]
        if failed.failed:
            raise SolveError(f"The plant failed before its steady state. {failed.sentence}")
        signals = self.signals(row)
        seen = cast("list[float]", lanes.observe(signals)[:, lane].tolist())
        return SteadyPoint(
            self.system,
            tuple(signals[:, lane].tolist()),
            self.drive,
            lanes.state[:, lane].copy(),
            dict(zip(lanes.names, seen, strict=True)),
            self.direction,
        )


def settle_lanes(lanes: Lanes, signals: Numbers, doublings: int = DOUBLINGS, settled: float = SETTLED) -> None:
    """Hold signals, (drives, batch elements), until what is judged has settled, in stretches that double so often.

    Raises:
        SolveError: that takes too long.
    """
    system, names = lanes.system, lanes.names
    judged = system.convergence_scales()
    places = [names.index(name) for name in judged]
    sizes = np.array(list(judged.values()))[:, None]
    dt = system.sample_time() or longest_step(system)
    last, stretch = lanes.observe(signals)[places], STRETCH
    for _ in range(doublings):
        held = np.broadcast_to(signals, (stretch, *signals.shape))
        lanes.advance(held, dt, shown=False)
        now = lanes.observe(signals)[places]
        if np.max(np.abs(now - last) / sizes, initial=0.0) <= settled:
            return
        last, stretch = now, stretch * 2
    raise SolveError(
        f"The system does not reach a steady state within {stretch * dt:.3g} s under held drives: it vibrates, turns "
        "or is very slow."
    )
