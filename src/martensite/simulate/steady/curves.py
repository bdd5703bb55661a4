"""Solution curves of user-defined equations, with their folds, and fold curves in a second parameter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from martensite.base.errors import ParameterError, SolveError
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.steady.continuation import STEADY_STEPS, Curve, CurvePoint, CurveSteps, Equations, Linearised
from martensite.simulate.steady.folds import FoldEquations, find_fold
from martensite.simulate.steady.periodic_motion import PeriodicMotion
from martensite.simulate.steady.rotations import ResponseCurve, require_same_heat

Residual = Callable[[Numbers], Sequence[float] | Numbers | float]
Sizes = Sequence[float] | Callable[[Numbers], Sequence[float] | Numbers] | None
"""Scale of each unknown, or a function of the unknowns that returns the scales."""
LEAST_SIZE = 1e-3
"""Size of an unknown near 0, where none is given."""
NUDGE = 1e-6
"""By how much an unknown is moved to difference a residual, in its size: third root of rounding."""


@dataclass(frozen=True, eq=False)
class SolutionCurve:
    """Solutions along a parameter."""

    unknowns: Numbers
    """(points, unknowns); the last column is the parameter."""
    fold: Numbers
    """True where the parameter turns back, (points,)."""

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
        return cls(np.array([one.unknowns for one in points]), np.array([one.fold for one in points]))


class DifferencedEquations:
    """Equations that are a function of the unknowns, whose derivatives are central differences."""

    def __init__(self, residual: Residual, sizes: Sizes) -> None:
        self.residual, self._sizes = residual, sizes

    def _choose_sizes(self, point: Numbers) -> Numbers:
        given = self._sizes
        if given is None:
            return np.maximum(np.abs(point), LEAST_SIZE)
        return np.asarray(given(point) if callable(given) else given, float)

    def linearise(self, point: Numbers) -> Linearised:
        """Return the residual and its derivatives at a point."""
        sizes = self._choose_sizes(point)
        value = np.atleast_1d(np.asarray(self.residual(point), float))
        columns = list[Numbers]()
        for k, size in enumerate(sizes):
            step = np.zeros(len(point))
            step[k] = NUDGE * size
            ahead, behind = (np.atleast_1d(np.asarray(self.residual(point + s * step), float)) for s in (1.0, -1.0))
            columns.append((ahead - behind) / (2.0 * NUDGE * size))
        return Linearised(value, np.array(columns).T, sizes)


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
    """Follow the solutions of equations along their last unknown, around its folds.

    Args:
        residual: what must be 0, a function of the array of unknowns; one equation fewer than unknowns.
        guess: near a solution; the last one, the parameter, is taken as it is.
        low: lower bound of the parameter.
        high: its upper bound.
        up: whether the curve begins with the parameter going up.
        sizes: what counts as a change of each unknown, or a function of them that says so; by default the size of
            each, or 0.001. Near a sharp resonance that of a frequency is its distance from it: steps that are too
            long go from one side of the peak to the other.
        how: lengths of the steps along the curve.

    Raises:
        ParameterError: the parameter does not begin between its bounds.
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
    """Follow a fold of equations in a second parameter, both ways to its bounds.

    Args:
        residual: what must be 0; the last two unknowns are the parameters, the last one is followed.
        fold: near a fold; the last one is taken as it is.
        low: lower bound of the second parameter.
        high: its upper bound.
        sizes: what counts as a change of each unknown, or a function of them that says so; by default the size of
            each, or 0.001. Near a sharp resonance that of a frequency is its distance from it: steps that are too
            long go from one side of the peak to the other.
        how: lengths of the steps along the curve.

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
    """Return the curve of a fold, from the lower bound or where it ends there, to the other end."""
    halves = list[list[CurvePoint]]()
    for direction in (-1.0, 1.0):
        folds = FoldEquations(equations)
        begun = Curve(folds, how).begin(find_fold(folds, guess, second), direction)
        half = list[CurvePoint]()
        try:
            half.extend(Curve(folds, how).follow(begun, low, high))
        except SolveError:
            if not half:
                raise
        halves.append(half)
    return SolutionCurve.collect([*halves[0][::-1], *halves[1][1:]])


@dataclass(frozen=True, eq=False)
class FoldCurve:
    """A fold of a response curve in a second parameter; arrays of shape (points,)."""

    names: tuple[str, str]
    """Names of the varied parameters: along the response curve, and the second one."""
    units: tuple[str, str]
    first: Numbers
    """First parameter at the fold, in SI."""
    second: Numbers
    """For which value of the second parameter, in SI."""
    cusp: Numbers
    """Points at which two folds meet."""


def trace_folds(
    curve: ResponseCurve, place: int, over: str, low: float, high: float, *, how: CurveSteps = STEADY_STEPS
) -> FoldCurve:
    """Follow a fold of a response curve in a second parameter: a boundary in two numbers.

    Args:
        curve: a response curve.
        place: which of its folds, counted from 0.
        over: what else is varied: a drive, or the path (or unique ending) of a number.
        low: its lower bound, in SI.
        high: its upper bound, in SI; what it is now must lie between.
        how: lengths of the steps along the curve.

    Raises:
        ParameterError: the fold or parameter does not exist, or the bounds do not enclose the present value.
        SolveError: the fold cannot be followed, or an element that remembers is heated or cooled along it.
    """
    points = [one for one in curve.points if one.fold]
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
    found = _follow_folds(both, points[place].unknowns, now, low, high, how)
    seen = [both.observe(point)[1] for point in found.unknowns]
    require_same_heat(both, {name: np.array([one[name].mean() for one in seen]) for name in seen[0]})
    return FoldCurve(
        (curve.varied.name, varied.name),
        (curve.varied.unit, varied.unit),
        found.unknowns[:, -2],
        found.unknowns[:, -1],
        found.fold,
    )
