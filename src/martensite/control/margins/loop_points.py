"""Operating points along the reference of a loop, on both branches, with their linear loops."""

from __future__ import annotations

import numpy as np

from martensite.base.errors import InputError
from martensite.control.controllers.mpc import Mpc
from martensite.control.margins.linear_controller import list_step_answers
from martensite.control.margins.linear_loop import LinearLoop, linearise_dead_band, linearise_loops
from martensite.control.margins.loop_case import LoopCase
from martensite.control.synthesis.rest_curves import RestCurve, read_at_rest
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.operating_point import SteadyPoint

POINTS = 3
"""Number of points of a branch."""
INNER = 0.1
"""Fraction of the reachable range that is excluded at either end."""
SOON = 5
"""Samples after which the first answer to a step of the reading is over."""
ALIKE = 2.0
"""Factor of the slope of the plant within which a linear system is valid."""


def linearise_case(case: LoopCase, count: int = POINTS) -> list[LinearLoop]:
    """Return the loops at points of both branches along the reference, and a loop in the dead band.

    Raises:
        InputError: the controller plans, or only switches.
    """
    if not any(list_first_answers(case)):
        raise InputError(f"`{case.controller.registered_name}` does not answer small changes: it has no linear system")
    points, turn = choose_points(case, count)
    return [*linearise_loops(case.bench, case.drive, points, turn), linearise_dead_band(case.bench, case.drive, turn)]


def list_first_answers(case: LoopCase) -> list[float]:
    """Return the changes of the signal per unit step of the reading, in the first samples."""
    if isinstance(case.controller, Mpc):
        raise InputError(f"`{case.controller.registered_name}` plans: it has no linear system")
    middle = case.heating.point(len(case.heating.levels) // 2)
    return list_step_answers(case.controller, read_at_rest(case.bench, middle.outputs), case.bench.period, SOON + 1)


def choose_points(case: LoopCase, count: int = POINTS) -> tuple[list[SteadyPoint], SteadyPoint]:
    """Return operating points on both branches along the reference, and the point where the branches meet.

    The cooling branch begins at the highest reference: inner loops have other slopes than the outer loop.
    """
    heated = case.read(case.heating)
    way = float(np.sign(heated[-1] - heated[0]))
    least, most = sorted((float(way * heated[0]), float(way * heated[-1])))
    inner, wanted = INNER * (most - least), way * case.reference
    high = min(max(float(wanted.max()), least + 2.0 * inner), most - inner)
    low = min(max(float(wanted.min()), least + inner), high)
    turn = _find_nearest(case.heating, way * heated, high)
    cooling = case.compute_branch(turn.signal, turn.state)
    cooled = way * case.read(cooling)
    start = high - min(inner, (high - low) / 3.0)  # behind the dead band
    end = min(max(low, float(cooled.min()) + 0.5 * inner), start)
    rows = ((case.heating, way * heated, high), (cooling, cooled, start))
    chosen = [
        (curve, sorted({int(np.argmin(np.abs(readings - at))) for at in np.linspace(bottom, top, count)}))
        for (curve, readings, top), bottom in zip(rows, (low, end), strict=True)
    ]
    return [curve.point(k) for curve, places in chosen for k in places], turn


def _find_nearest(curve: RestCurve, readings: Numbers, level: float) -> SteadyPoint:
    return curve.point(int(np.argmin(np.abs(readings - level))))


def find_validity(case: LoopCase, one: LinearLoop) -> tuple[float, float]:
    """Return the readings around a point between which the slope of its branch is within a factor of `ALIKE`.

    On the cooling branch the outer loop is used; in the dead band the range is empty.
    """
    if one.branch == "dead band":
        return one.reading, one.reading
    curve = case.heating if one.branch == "heating" else case.cooling
    readings = case.read(curve)
    slopes = np.abs(np.diff(readings) / np.diff(curve.levels))
    k = int(np.argmin(np.abs(0.5 * (readings[1:] + readings[:-1]) - one.reading)))
    alike = (slopes >= slopes[k] / ALIKE) & (slopes <= slopes[k] * ALIKE)
    off = np.flatnonzero(~alike)
    first = max((j + 1 for j in off if j < k), default=0)
    last = min((j for j in off if j > k), default=len(slopes))
    return float(readings[first]), float(readings[last])
