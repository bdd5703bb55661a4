"""Steady states of a plant under constant signals, along both branches, with their readings.

The heating branch starts without a signal, the cooling branch at the end of the heating branch.
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
"""Doublings after which a plant is unsettled; relative change that counts as zero."""


@dataclass(frozen=True, eq=False)
class RestCurve:
    """Steady states under rising or falling signals."""

    system: AbstractSystem
    drive: str
    direction: Direction
    signals: Numbers
    """Signals of all drives, shape (drives, points)."""
    states: Numbers
    """Flat states, shape (states, points)."""
    outputs: dict[str, Numbers]

    @property
    def levels(self) -> Numbers:
        """Return the signals of the varied drive."""
        return self.signals[[one.name for one in self.system.drives()].index(self.drive)]

    def point(self, k: int) -> SteadyPoint:
        """Return the operating point at signal k."""
        outputs = {name: float(column[k]) for name, column in self.outputs.items()}
        signals = cast("list[float]", self.signals[:, k].tolist())
        return SteadyPoint(self.system, tuple(signals), self.drive, self.states[:, k].copy(), outputs, self.direction)


def compute_rest_curve(
    system: AbstractSystem,
    drive: str,
    row: Numbers,
    *,
    others: Mapping[str, float] | None = None,
    start: Numbers | None = None,
) -> RestCurve:
    """Compute the steady state under each signal of a row.

    Args:
        system: the plant.
        drive: varied drive.
        row: its signals.
        others: constant signals of other drives; default: 0.
        start: flat state from which the plant cools; default: heating without a prior signal.

    Raises:
        SolveError: the plant does not settle.
    """
    names = [one.name for one in system.drives()]
    base = np.array([float((others or {}).get(name, 0.0)) for name in names])
    table = np.repeat(base[:, None], len(row), axis=1)
    table[names.index(drive)] = row
    lanes = Lanes(system, len(row), soon=True)
    lanes.reset(base[:, None])
    if start is not None:
        lanes.state = np.repeat(start[:, None], len(row), axis=1)
    settle_lanes(lanes, table, PATIENCE, SETTLED)
    table_of_outputs = lanes.observe(table)
    good = np.array([not one.failed for one in lanes.status]) & np.isfinite(table_of_outputs).all(axis=0)
    if not good.any():
        raise SolveError("The plant fails under every constant signal.")
    outputs = dict(zip(lanes.names, table_of_outputs[:, good], strict=True))
    way: Direction = "heating" if start is None else "cooling"
    return RestCurve(system, drive, way, table[:, good], lanes.state[:, good], outputs)


def read_at_rest(bench: Bench, truth: Mapping[str, float]) -> dict[str, float]:
    """Return the steady readings of controllers: readings of sensors, true estimates, and ages of 0."""
    truth_with_ambient = dict(truth)
    for port, one in bench.plant.actuators().items():
        truth_with_ambient[bench.plant.label(port, AMBIENT)] = float(one.environment.temperature)
    mounted = bench.sensors.members().items()
    readings = {
        name: float(one.rest(floats, truth_with_ambient, 0.0, 1).reading) for name, one in mounted
    } or truth_with_ambient
    estimates = {name: truth_with_ambient.get(name.removeprefix(ESTIMATED), 0.0) for name in list_readings(bench)}
    return {name: 0.0 if name.endswith(AGE) else readings.get(name, estimates[name]) for name in estimates}


def read_curve(bench: Bench, curve: RestCurve, name: str) -> Numbers:
    """Return a reading of a bench along a curve."""
    rows = np.stack(list(curve.outputs.values()), axis=1).tolist()
    return np.array([read_at_rest(bench, dict(zip(curve.outputs, row, strict=True)))[name] for row in rows])
