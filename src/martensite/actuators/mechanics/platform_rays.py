r"""Where one leg of a platform moves it alone.

If the two other legs are equal linear springs, free of force at home, their pulls
J_j (L_j - h) must balance the pull J_i F_i of leg i:

    J_i × Σ_{j≠i} J_j (L_j - h) = 0

F_i and the stiffness drop out: one leg reaches a curve only. For leg 0 it is β = 0; those of
legs 1 and 2 leave home at 120° to it and bend, since the joint turns about X in the plate and
about Y in the base. Gravity is left out; for a joint at the centroid of the plate there is none.

Source: the balance of torques, solved for this project; J as in `platform_kinematics`.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from martensite.actuators.mechanics.platform_kinematics import Plates, compute_length_slopes
from martensite.kernels import floats
from martensite.kernels.bracketed_newton import solve_bracketed
from martensite.kernels.namespace import Namespace, Scalar

HALVINGS = 40
TURNS = 6
"""Bracketed Newton steps for the direction of a ray, from that of the last point."""
SWING = 0.2
"""Largest change of direction of a ray from one point to the next [rad]."""
BALANCED = 1e-9
"""Largest pull across that counts as none, as a share of the plates' side cubed."""

Angles = tuple[float, float]


def compute_crosswise(xp: Namespace, plates: Plates, leg: int, alpha: Scalar, beta: Scalar) -> Scalar:
    """What two springs of unit rate pull across the third [m³/rad²]; 0 where that is balanced."""
    found, over_alpha, over_beta = compute_length_slopes(xp, plates, alpha, beta)
    rows = list(zip(found, over_alpha, over_beta, strict=True))
    _, own_alpha, own_beta = rows.pop(leg)
    (first, a1, b1), (second, a2, b2) = rows
    first, second = first - plates.height, second - plates.height
    pull_alpha, pull_beta = a1 * first + a2 * second, b1 * first + b2 * second
    return own_beta * pull_alpha - own_alpha * pull_beta


def trace_ray(plates: Plates, leg: int, step: float, allowed: Callable[[float, float], bool]) -> list[Angles]:
    """The curve of one leg: home, points (α, β) one step [rad] apart, and the end if it moves.

    It ends where postures are no longer allowed or the leg gets no shorter; early, if it swings
    round too fast to be followed with this step.
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
    """The posture at a distance from home [rad], near a heading, that one leg brings about."""

    def unbalance(xp: Namespace, turn: Scalar) -> Scalar:
        alpha, beta = radius * xp.cos(turn), radius * xp.sin(turn)
        return compute_crosswise(xp, plates, leg, alpha, beta) / radius

    bracket = (heading - SWING, heading + SWING)
    turn = solve_bracketed(floats, unbalance, heading, bracket, TURNS)
    return radius * math.cos(turn), radius * math.sin(turn)


def _is_pulling(plates: Plates, leg: int, alpha: float, beta: float) -> bool:
    """Whether a leg balances the others, and still gets shorter on its way out."""
    _, over_alpha, over_beta = compute_length_slopes(floats, plates, alpha, beta)
    across = compute_crosswise(floats, plates, leg, alpha, beta)
    shorter = alpha * over_alpha[leg] + beta * over_beta[leg] < 0.0
    return shorter and abs(across) <= BALANCED * plates.side**3


def find_last(holds: Callable[[float], bool], low: float, high: float) -> float:
    """Where a condition ends that holds at `low` and not at `high`, by halving."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low
