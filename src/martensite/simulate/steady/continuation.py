r"""Pseudo-arclength continuation of solutions of F(z) = 0 with one more unknown than equations.

From a point z on the curve with the unit tangent t, the next point solves

F(z') = 0,        t · (z' - z) = h

with Newton steps. The curve is thus followed around folds, where the last unknown, the parameter, reverses.
Unknowns are scaled by `sizes`, updated at every point, so h is about their relative change. Steps use the
minimum-norm solution, which omits directions without effect, such as unused memory.

At a fold, the parameter component of the tangent changes sign. Brent's method locates its zero over the step length
h, with a corrected point at each trial.

Source: Keller (1977), Numerical solution of bifurcation and nonlinear eigenvalue problems; Doedel (1981).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from martensite.base.errors import SolveError
from martensite.kernels.brent import find_root
from martensite.signals.sampling.sampled import Numbers

ITERATIONS = 12
"""Maximum Newton steps of a correction."""
QUICK = 5
"""Newton steps above which the next curve step is not longer."""
SETTLED, GOOD = 1e-11, 1e-6
"""Lengths of a final Newton step: for convergence, and for acceptance after stagnation."""
RANK = 1e-10
"""Fraction of the largest singular value below which a direction has no effect."""
CORNER = 1e-3
"""Step length below which sharp corners are accepted, as at a wire that goes taut."""
SHORTEST = 1e-7
"""Smallest step of the curve."""


class LinearisedEquations(NamedTuple):
    """Equations at a point."""

    residual: Numbers
    """Scaled residual, (equations,), large at 1."""
    jacobian: Numbers
    """d(residual)/d(unknown), (equations, unknowns)."""
    sizes: Numbers
    """Scale of each unknown, (unknowns,)."""


class Equations(Protocol):
    """Equations for continuation; the last unknown is the parameter."""

    def linearise(self, point: Numbers) -> LinearisedEquations:
        """Return the residual and its derivatives at a point."""
        ...


@dataclass(frozen=True, eq=False)
class CurvePoint:
    """Point of a curve."""

    unknowns: Numbers
    """Unknowns; the last one is the parameter."""
    tangent: Numbers
    """Tangent of unit length, in units of `sizes`."""
    sizes: Numbers
    is_fold: bool = False

    @property
    def parameter(self) -> float:
        """Return the last unknown."""
        return float(self.unknowns[-1])

    @property
    def turn(self) -> float:
        """Return the rate of the parameter along the curve; 0 at a fold."""
        return float(self.tangent[-1])


@dataclass(frozen=True)
class CurveSteps:
    """Step settings along a curve."""

    first: float = 0.05
    longest: float = 0.3
    """Longest step, as a fraction of the sizes of the unknowns."""
    most: int = 600
    """Maximum number of points."""


STEADY_STEPS = CurveSteps()
"""Default step settings."""


def correct_point(
    equations: Equations, guess: Numbers, normal: Numbers, sizes: Numbers | None = None
) -> tuple[Numbers, LinearisedEquations, int]:
    """Return the solution in the plane through a guess with a normal, and the number of Newton steps.

    Args:
        equations: equations to solve.
        guess: start of the iteration.
        normal: normal of the plane, scaled by the sizes.
        sizes: scales of the unknowns; by default from the equations.

    Raises:
        SolveError: Newton's method does not converge.
    """
    point, last = np.array(guess, float), np.inf
    for number in range(1, ITERATIONS + 1):
        linear = equations.linearise(point)
        if not (np.isfinite(linear.residual).all() and np.isfinite(linear.jacobian).all()):
            break
        units = linear.sizes if sizes is None else sizes
        aside = normal @ ((point - guess) / units)
        matrix = np.vstack([linear.jacobian * units, normal])
        change = np.linalg.lstsq(matrix, -np.append(linear.residual, aside), rcond=RANK)[0]
        point = point + change * units
        length = float(np.linalg.norm(change))
        if length <= SETTLED or (length <= GOOD and length > 0.3 * last):
            return point, linear, number
        if length > 1e3:
            break
        last = length
    raise SolveError("Newton's method finds no solution near the guess.")


def find_tangent(linear: LinearisedEquations, along: Numbers) -> Numbers:
    """Return the unit tangent of the curve at a point, in the direction of `along`.

    Of all directions with constant residual, the nearest to `along` is used.
    """
    scaled = linear.jacobian * linear.sizes
    _, singular, rows = np.linalg.svd(scaled, full_matrices=True)
    rank = int(np.sum(singular > RANK * singular[0]))
    rank = min(rank, len(rows) - 1)
    free = rows[rank:]
    tangent = free.T @ (free @ along)
    length = float(np.linalg.norm(tangent))
    if not length > 1e-6:
        raise SolveError("The curve has no tangent here: two branches may cross.")
    return tangent / length


class Curve:
    """Curve from a solution in one direction."""

    def __init__(self, equations: Equations, steps: CurveSteps = STEADY_STEPS) -> None:
        self.equations, self.steps = equations, steps

    def begin(self, guess: Numbers, direction: float) -> CurvePoint:
        """Return the solution at the parameter of a guess and set the direction.

        Raises:
            SolveError: no solution is nearby.
        """
        normal = np.zeros(len(guess))
        normal[-1] = np.copysign(1.0, direction)
        point, linear, _ = correct_point(self.equations, guess, normal)
        return CurvePoint(point, find_tangent(linear, normal), linear.sizes)

    def step(self, begin: CurvePoint, length: float) -> tuple[CurvePoint, int]:
        """Return the point at a length along the curve, and the number of Newton steps."""
        guess = begin.unknowns + length * begin.tangent * begin.sizes
        point, linear, number = correct_point(self.equations, guess, begin.tangent, begin.sizes)
        along = begin.tangent * begin.sizes / linear.sizes
        return CurvePoint(point, find_tangent(linear, along), linear.sizes), number

    def follow(self, begin: CurvePoint, low: float, high: float) -> Iterator[CurvePoint]:
        """Yield the points from a solution to the bounds of the parameter, with folds.

        Raises:
            SolveError: the curve cannot be followed further.
        """
        here, length = begin, self.steps.first
        yield here
        for _ in range(self.steps.most):
            there, length = self._advance(here, length)
            if here.turn * there.turn < 0.0 and not here.is_fold:
                yield (fold := self.locate(here, there, lambda one: one.turn, length_of(here, there), True))
                if not low <= fold.parameter <= high:
                    return
            if not low < there.parameter < high:
                bound = low if there.parameter <= low else high
                yield self._end_at(bound, here, there)
                return
            yield there
            here = there
        raise SolveError(f"The curve has more than {self.steps.most} points.")

    def _advance(self, here: CurvePoint, length: float) -> tuple[CurvePoint, float]:
        """Return the next point, and the length of the step after it."""
        while length >= SHORTEST:
            try:
                there, number = self.step(here, length)
                if length < CORNER or _agree(here, there):
                    longer = length * (1.6 if number < QUICK else 1.0)
                    return there, min(longer, self.steps.longest)
            except SolveError:
                pass
            length *= 0.5
        raise SolveError(
            f"The curve of steady states cannot be followed beyond a parameter of {here.parameter:.6g}: it ends, or "
            "breaks off, there."
        )

    def _end_at(self, bound: float, here: CurvePoint, there: CurvePoint) -> CurvePoint:
        """Return the point at which the curve reaches a bound of the parameter."""
        near = self.locate(here, there, lambda one: one.parameter - bound, length_of(here, there))
        guess, normal = near.unknowns.copy(), np.zeros(len(near.unknowns))
        guess[-1], normal[-1] = bound, 1.0
        point, linear, _ = correct_point(self.equations, guess, normal)
        return CurvePoint(point, find_tangent(linear, near.tangent), linear.sizes)

    def locate(
        self,
        here: CurvePoint,
        there: CurvePoint,
        function: Callable[[CurvePoint], float],
        length: float,
        fold: bool = False,
    ) -> CurvePoint:
        """Return the point between two points at which a function is 0."""
        points = {0.0: here, length: there}

        def value(at: float) -> float:
            if at not in points:
                points[at] = self.step(here, at)[0]
            return function(points[at])

        root = find_root(value, 0.0, length, relative=1e-14)
        value(root)
        one = points[root]
        return CurvePoint(one.unknowns, one.tangent, one.sizes, fold)


def length_of(here: CurvePoint, there: CurvePoint) -> float:
    """Return the step length between two points."""
    return float(here.tangent @ ((there.unknowns - here.unknowns) / here.sizes))


def _agree(here: CurvePoint, there: CurvePoint) -> bool:
    """Return whether two directions of the curve are similar."""
    along = here.tangent * here.sizes / there.sizes
    return float(along @ there.tangent) > 0.9 * float(np.linalg.norm(along))
