"""Workspace of a platform: the angles with all leg lengths between two limits.

Reachable angles are connected to the home posture. The set is found on a grid by flood fill from home, its extents
along both axes by bisection. A single leg reaches only a curve.

Source: the lengths of `platform_kinematics`.

If the two other legs are equal linear springs without force at home, their pulls J_j (L_j - h) must balance the pull
J_i F_i of leg i:

    J_i × Σ_{j≠i} J_j (L_j - h) = 0

F_i and the stiffness cancel. For leg 0 the curve is β = 0; the curves of legs 1 and 2 leave home at 120° to it and
bend, since the joint turns about X in the plate and about Y in the base. Gravity is neglected; at the centroid of the
plate its torque is zero.

Source: the balance of torques, solved for this project; J as in `platform_kinematics`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from martensite.actuators.mechanics.platform_kinematics import (
    Plates,
    check_number,
    check_plates,
    compute_length_slopes,
    compute_lengths,
    format_millimetres,
)
from martensite.base.errors import ParameterError
from martensite.kernels import floats
from martensite.kernels.bracketed_newton import solve_bracketed
from martensite.kernels.namespace import Namespace, Scalar

STEP = math.radians(0.5)
FINEST, COARSEST = math.radians(0.05), math.radians(5.0)
QUARTER = math.pi / 2
"""Upper bound of both angles [rad]."""


@dataclass(frozen=True)
class Legs:
    """The legs of a platform and their length limits [m]."""

    plates: Plates
    shortest: float
    longest: float

    def allow(self, alpha: float, beta: float) -> bool:
        """Return whether all legs are within their limits at angles [rad], reachable or not."""
        lengths = compute_lengths(floats, self.plates, alpha, beta)
        inside = self.shortest <= min(lengths) and max(lengths) <= self.longest
        return inside and max(abs(alpha), abs(beta)) < QUARTER


@dataclass(frozen=True)
class Workspace:
    """The reachable set of a platform. Angles are (α, β) [rad]."""

    legs: Legs
    step: float
    """Grid step [rad]."""
    alphas: list[float]
    """Angles α of the grid, one line wider than the set at each end [rad]."""
    betas: list[float]
    """Angles β of the grid, one line wider than the set at each end [rad]."""
    reached: list[list[bool]]
    """True if a grid point is reachable, indexed [α][β]."""
    alpha_extent: Angles
    """Range of α along β = 0 from home [rad], to 1e-12."""
    beta_extent: Angles
    """Range of β along α = 0 from home [rad], to 1e-12."""
    rays: list[list[Angles]]
    """Curve of each leg alone, from home outwards."""

    @property
    def bounds(self) -> tuple[Angles, Angles]:
        """Return the ranges of α and β of the whole set [rad], to one grid step."""
        alphas, betas = zip(*self.points(), strict=True)
        return (min(alphas), max(alphas)), (min(betas), max(betas))

    def points(self) -> list[Angles]:
        """Return all reachable points of the grid."""
        rows = zip(self.alphas, self.reached, strict=True)
        return [(a, b) for a, row in rows for b, flag in zip(self.betas, row, strict=True) if flag]


def reachable_angles(plates: Plates, shortest: float, longest: float, step: float = STEP) -> Workspace:
    """Return the postures that a platform can reach from home within leg length limits.

    Args:
        plates: geometry.
        shortest: smallest length of a leg [m].
        longest: largest length of a leg [m].
        step: grid step [rad], 0.05° to 5°. Narrower obstacles can be missed.

    Returns:
        The set on its grid, its extents, and the curves of single legs.

    Raises:
        ParameterError: a value is not allowed, or the home posture is outside the limits.
    """
    check_plates(plates)
    check_number("length `shortest`", shortest)
    check_number("length `longest`", longest)
    if not FINEST <= step <= COARSEST:
        raise ParameterError(f"The `step` must be 0.05 to 5 degrees, but is {step:g} rad.")
    if not shortest <= plates.height <= longest:
        raise ParameterError(
            f"At home the legs are as long as the plates' distance, {format_millimetres([plates.height])}, which is "
            f"not within {format_millimetres([shortest, longest])}. Widen the limits."
        )
    return _explore_grid(Legs(plates, shortest, longest), step)


def _explore_grid(legs: Legs, step: float) -> Workspace:
    cells = _flood_cells(lambda i, j: legs.allow(i * step, j * step))
    rows, columns = (_pad_numbers([cell[axis] for cell in cells]) for axis in (0, 1))
    reach = [_measure_reach(legs, step, *way) for way in ((-1, 0), (1, 0), (0, -1), (0, 1))]
    return Workspace(
        legs,
        step,
        alphas=[i * step for i in rows],
        betas=[j * step for j in columns],
        reached=[[(i, j) in cells for j in columns] for i in rows],
        alpha_extent=(-reach[0], reach[1]),
        beta_extent=(-reach[2], reach[3]),
        rays=[trace_ray(legs.plates, leg, step, legs.allow) for leg in range(3)],
    )


def _flood_cells(allowed: Callable[[int, int], bool]) -> set[tuple[int, int]]:
    """Return all cells connected to (0, 0) through sides."""
    cells, edge = {(0, 0)}, [(0, 0)]
    while edge:
        i, j = edge.pop()
        for cell in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            if cell not in cells and allowed(*cell):
                cells.add(cell)
                edge.append(cell)
    return cells


def _pad_numbers(numbers: list[int]) -> range:
    return range(min(numbers) - 1, max(numbers) + 2)


def _measure_reach(legs: Legs, step: float, alpha: int, beta: int) -> float:
    """Return the allowed distance from home along one half of an axis [rad]."""

    def holds(far: float) -> bool:
        return legs.allow(far * alpha, far * beta)

    far = step
    while holds(far):
        far += step
    return find_last(holds, far - step, far)


HALVINGS = 40
TURNS = 6
"""Bracketed Newton steps for the direction of a ray."""
SWING = 0.2
"""Largest change of direction of a ray between points [rad]."""
BALANCED = 1e-9
"""Largest unbalanced pull, relative to the cubed side of the plates."""

Angles = tuple[float, float]


def compute_crosswise(xp: Namespace, plates: Plates, leg: int, alpha: Scalar, beta: Scalar) -> Scalar:
    """Return the pull of two springs of unit rate across the third [m³/rad²]; 0 in balance."""
    lengths, over_alpha, over_beta = compute_length_slopes(xp, plates, alpha, beta)
    rows = list(zip(lengths, over_alpha, over_beta, strict=True))
    _, own_alpha, own_beta = rows.pop(leg)
    (first, a1, b1), (second, a2, b2) = rows
    first, second = first - plates.height, second - plates.height
    pull_alpha, pull_beta = a1 * first + a2 * second, b1 * first + b2 * second
    return own_beta * pull_alpha - own_alpha * pull_beta


def trace_ray(plates: Plates, leg: int, step: float, allowed: Callable[[float, float], bool]) -> list[Angles]:
    """Return the curve of one leg: home, points (α, β) one step [rad] apart, and the end.

    It ends where postures are not allowed or the leg gets no shorter; or early, if it turns too fast for this step.
    """
    heading = leg * 2.0 * math.pi / 3.0
    points, far = [(0.0, 0.0)], step

    def at(radius: float) -> Angles:
        return find_balanced(plates, leg, radius, heading)

    def holds(radius: float) -> bool:
        return allowed(*at(radius)) and _is_pulling(plates, leg, *at(radius))

    while holds(far):
        points.append(at(far))
        heading = math.atan2(*reversed(points[-1]))
        far += step
    end = find_last(holds, far - step, far)
    return [*points, at(end)] if end > far - step else points


def find_balanced(plates: Plates, leg: int, radius: float, heading: float) -> Angles:
    """Return the posture of one leg at a distance from home [rad], near a heading."""

    def unbalance(xp: Namespace, turn: Scalar) -> Scalar:
        alpha, beta = radius * xp.cos(turn), radius * xp.sin(turn)
        return compute_crosswise(xp, plates, leg, alpha, beta) / radius

    bracket = (heading - SWING, heading + SWING)
    turn = solve_bracketed(floats, unbalance, heading, bracket, TURNS)
    return radius * math.cos(turn), radius * math.sin(turn)


def _is_pulling(plates: Plates, leg: int, alpha: float, beta: float) -> bool:
    """Return whether a leg balances the others, and still gets shorter outwards."""
    _, over_alpha, over_beta = compute_length_slopes(floats, plates, alpha, beta)
    across = compute_crosswise(floats, plates, leg, alpha, beta)
    shorter = alpha * over_alpha[leg] + beta * over_beta[leg] < 0.0
    return shorter and abs(across) <= BALANCED * plates.side**3


def find_last(holds: Callable[[float], bool], low: float, high: float) -> float:
    """Return the end of a condition that holds at `low` and not at `high`, by bisection."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low
