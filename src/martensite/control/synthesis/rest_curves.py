"""Steady states of a plant under constant signals, along both branches, and the readings there.

The heating branch is reached from rest without a signal, the cooling branch from where the heating branch ends.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import SolveError
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import AGE, AMBIENT, list_readings
from martensite.control.observers.base import ESTIMATED
from martensite.kernels import floats
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.lanes import Lanes
from martensite.simulate.operating_point import Direction, SteadyPoint, settle_lanes

PATIENCE, SETTLED = 6, 1e-6
"""Doublings of a stretch after which a plant counts as unsettled; change that counts as zero, over the least size."""


@dataclass(frozen=True, eq=False)
class RestCurve:
    """States of rest under signals that go one way."""

    system: AbstractSystem
    drive: str
    direction: Direction
    signals: Numbers
    """Signals of all drives, shape (drives, points)."""
    states: Numbers
    """Flat, shape (states, points)."""
    outputs: dict[str, Numbers]

    @property
    def levels(self) -> Numbers:
        """Return the signals of the drive that is varied."""
        return self.signals[[one.name for one in self.system.drives()].index(self.drive)]

    def point(self, k: int) -> SteadyPoint:
        """Return the operating point at one of the signals."""
        seen = {name: float(column[k]) for name, column in self.outputs.items()}
        signals = cast("list[float]", self.signals[:, k].tolist())
        return SteadyPoint(self.system, tuple(signals), self.drive, self.states[:, k].copy(), seen, self.direction)


def compute_rest_curve(
    system: AbstractSystem,
    drive: str,
    row: Numbers,
    *,
    others: Mapping[str, float] | None = None,
    start: Numbers | None = None,
) -> RestCurve:
    """Rest under each signal of a row: on the heating branch from rest, on the cooling branch from a hot `start`.

    Args:
        system: the plant.
        drive: the one that is varied.
        row: its signals.
        others: constant signals of other drives; what is not named gets 0.
        start: flat state from which it cools.

    Raises:
        SolveError: it does not come to rest.
    """
    names = [one.name for one in system.drives()]
    base = np.array([float((others or {}).get(name, 0.0)) for name in names])
    table = np.repeat(base[:, None], len(row), axis=1)
    table[names.index(drive)] = row
    lanes = Lanes(system, len(row))
    lanes.reset(base[:, None])
    if start is not None:
        lanes.state = np.repeat(start[:, None], len(row), axis=1)
    settle_lanes(lanes, table, PATIENCE, SETTLED)
    seen = lanes.observe(table)
    good = np.array([not one.failed for one in lanes.status]) & np.isfinite(seen).all(axis=0)
    if not good.any():
        raise SolveError("The plant fails under every constant signal.")
    outputs = dict(zip(lanes.names, seen[:, good], strict=True))
    way: Direction = "heating" if start is None else "cooling"
    return RestCurve(system, drive, way, table[:, good], lanes.state[:, good], outputs)


def read_at_rest(bench: Bench, truth: Mapping[str, float]) -> dict[str, float]:
    """Return the readings of controllers at rest: readings of sensors, true estimates, and ages of 0."""
    known = dict(truth)
    for port, one in bench.plant.actuators().items():
        known[bench.plant.label(port, AMBIENT)] = float(one.environment.temperature)
    mounted = bench.sensors.members().items()
    seen = {name: float(one.rest(floats, known, 0.0, 1).reading) for name, one in mounted} or known
    guessed = {name: known.get(name.removeprefix(ESTIMATED), 0.0) for name in list_readings(bench)}
    return {name: 0.0 if name.endswith(AGE) else seen.get(name, guessed[name]) for name in guessed}


def read_curve(bench: Bench, curve: RestCurve, name: str) -> Numbers:
    """Return a reading of a bench along a curve."""
    rows = np.stack(list(curve.outputs.values()), axis=1).tolist()
    return np.array([read_at_rest(bench, dict(zip(curve.outputs, row, strict=True)))[name] for row in rows])
