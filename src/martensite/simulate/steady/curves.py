"""Solution curves of user-defined equations with folds, and fold curves in a second parameter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from martensite.base.errors import ParameterError, SolveError
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.steady.continuation import (
    STEADY_STEPS,
    Curve,
    CurvePoint,
    CurveSteps,
    Equations,
    LinearisedEquations,
)
from martensite.simulate.steady.folds import FoldEquations, find_fold
from martensite.simulate.steady.periodic_motion import PeriodicMotion
from martensite.simulate.steady.rotations import ResponseCurve, require_same_heat

Residual = Callable[[Numbers], Sequence[float] | Numbers | float]
Sizes = Sequence[float] | Callable[[Numbers], Sequence[float] | Numbers] | None
"""Scale of each unknown, or a function of the unknowns that returns the scales."""
LEAST_SIZE = 1e-3
"""Default size of an unknown near 0."""
NUDGE = 1e-6
"""Relative increment of finite differences: third root of rounding."""


@dataclass(frozen=True, eq=False)
class SolutionCurve:
    """Solutions along a parameter."""

    unknowns: Numbers
    """(points, unknowns); the last column is the parameter."""
    fold: Numbers
    """True at folds of the parameter, (points,)."""

    @property
    def parameter(self) -> Numbers:
        """Return the continued parameter, (points,)."""
        return self.unknowns[:, -1]

    @property
    def folds(self) -> Numbers:
        """Return the unknowns at the folds, (folds, unknowns)."""
        return self.unknowns[self.fold]

    @classmethod
    def collect(cls, points: Sequence[CurvePoint]) -> SolutionCurve:
        """Build a curve from points in their order."""
        return cls(np.array([one.unknowns for one in points]), np.array([one.is_fold for one in points]))


class DifferencedEquations:
    """Equations as a function of the unknowns, with derivatives by central differences."""

    def __init__(self, residual: Residual, sizes: Sizes) -> None:
        self.residual, self._sizes = residual, sizes

    def _choose_sizes(self, point: Numbers) -> Numbers:
        given = self._sizes
        if given is None:
            return np.maximum(np.abs(point), LEAST_SIZE)
        return np.asarray(given(point) if callable(given) else given, float)

    def linearise(self, point: Numbers) -> LinearisedEquations:
        """Return the residual and its derivatives at a point."""
        sizes = self._choose_sizes(point)
        value = np.atleast_1d(np.asarray(self.residual(point), float))
        columns = list[Numbers]()
        for k, size in enumerate(sizes):
            step = np.zeros(len(point))
            step[k] = NUDGE * size
            ahead, behind = (np.atleast_1d(np.asarray(self.residual(point + s * step), float)) for s in (1.0, -1.0))
            columns.append((ahead - behind) / (2.0 * NUDGE * size))
        return LinearisedEquations(value, np.array(columns).T, sizes)


def trace_curve(
    residual: Residual,
    guess: Sequence[float] | Numbers,
    low: float,
    high: float,
    *,
    up: bool = True,
    sizes: Sizes = None,
    how: CurveSteps = STEADY_STEPS,
) -> SolutionCurve:
    """Trace solutions of equations along their last unknown, around folds.

    Args:
        residual: function of the array of unknowns that must be 0; one equation fewer than unknowns.
        guess: point near a solution; the last unknown, the parameter, remains fixed.
        low: lower bound of the parameter.
        high: upper bound of the parameter.
        up: True to start with an increasing parameter.
        sizes: scale of each unknown, or a function that returns the scales; by default the value, at least 0.001.
            Near a sharp resonance, use the distance to it as the scale of a frequency. Longer steps can skip the peak.
        how: step settings along the curve.

    Raises:
        ParameterError: the initial parameter is outside its bounds.
        SolveError: no solution lies near the guess, or the curve cannot be followed.
    """
    start = np.asarray(guess, float)
    if not low <= start[-1] <= high:
        raise ParameterError(f"The curve must begin between {low:g} and {high:g}, but begins at {start[-1]:g}.")
    curve = Curve(DifferencedEquations(residual, sizes), how)
    begin = curve.begin(start, 1.0 if up else -1.0)
    return SolutionCurve.collect(list(curve.follow(begin, low, high)))


def trace_fold_curve(
    residual: Residual,
    fold: Sequence[float] | Numbers,
    low: float,
    high: float,
    *,
    sizes: Sizes = None,
    how: CurveSteps = STEADY_STEPS,
) -> SolutionCurve:
    """Trace a fold of equations in a second parameter, to both bounds.

    Args:
        residual: function that must be 0; the last two unknowns are the parameters, and the last one is followed.
        fold: point near a fold; the last unknown remains fixed.
        low: lower bound of the second parameter.
        high: upper bound of the second parameter.
        sizes: scale of each unknown, or a function that returns the scales; by default the value, at least 0.001.
            Near a sharp resonance, use the distance to it as the scale of a frequency. Longer steps can skip the peak.
        how: step settings along the curve.

    Returns:
        All unknowns along the curve; its folds are cusps, at which two folds meet.

    Raises:
        SolveError: no fold is near, or it cannot be followed.
    """
    start = np.asarray(fold, float)
    return _follow_folds(DifferencedEquations(residual, sizes), start[:-1], float(start[-1]), low, high, how)


def _follow_folds(
    equations: Equations, guess: Numbers, second: float, low: float, high: float, how: CurveSteps
) -> SolutionCurve:
    """Return the curve of a fold between both of its ends."""
    halves = list[list[CurvePoint]]()
    for direction in (-1.0, 1.0):
        folds = FoldEquations(equations)
        start = Curve(folds, how).begin(find_fold(folds, guess, second), direction)
        half = list[CurvePoint]()
        try:
            half.extend(Curve(folds, how).follow(start, low, high))
        except SolveError:
            if not half:
                raise
        halves.append(half)
    return SolutionCurve.collect([*halves[0][::-1], *halves[1][1:]])


@dataclass(frozen=True, eq=False)
class FoldCurve:
    """Fold of a response curve in a second parameter; arrays of shape (points,)."""

    names: tuple[str, str]
    """Names of the parameters: along the response curve, and the second one."""
    units: tuple[str, str]
    first: Numbers
    """First parameter at the fold, in SI."""
    second: Numbers
    """Second parameter, in SI."""
    cusp: Numbers
    """Points at which two folds meet."""


def trace_folds(
    curve: ResponseCurve, place: int, over: str, low: float, high: float, *, how: CurveSteps = STEADY_STEPS
) -> FoldCurve:
    """Trace a fold of a response curve in a second parameter, as a boundary in two parameters.

    Args:
        curve: a response curve.
        place: index of the fold, from 0.
        over: second parameter: a drive, or the path (or unique ending) of a parameter.
        low: lower bound, in SI.
        high: upper bound, in SI; the present value must lie between.
        how: step settings along the curve.

    Raises:
        ParameterError: the fold or parameter does not exist, or the bounds do not enclose the present value.
        SolveError: the fold cannot be followed, or an element with memory is heated or cooled along it.
    """
    points = [one for one in curve.points if one.is_fold]
    if not 0 <= place < len(points):
        raise ParameterError(f"The curve has {len(points)} folds, but no fold {place}.")
    motion, one = curve.motion, curve.subject
    varied = one.vary(over, low, high)
    now = one.value(varied, motion.signals)
    if not low <= now <= high:
        raise ParameterError(f"`{varied.name}` is {now:g} {varied.unit}, which its bounds must enclose.")
    both = PeriodicMotion(
        one.system, motion.signals, [curve.varied, varied], rotor=motion.rotor, steps=motion.steps, grid=motion.grid
    )
    both.angle = motion.angle
    boundary = _follow_folds(both, points[place].unknowns, now, low, high, how)
    outputs = [both.observe(point)[1] for point in boundary.unknowns]
    require_same_heat(both, {name: np.array([one[name].mean() for one in outputs]) for name in outputs[0]})
    return FoldCurve(
        (curve.varied.name, varied.name),
        (curve.varied.unit, varied.unit),
        boundary.unknowns[:, -2],
        boundary.unknowns[:, -1],
        boundary.fold,
    )
