"""Motions of a mechanism over a step: consistent positions, velocities and accelerations.

In every scheme, velocity and acceleration at the end of a step are linear in the position there, so the step is one
system of equations. Its unknowns are the offsets δ of the position from its prediction; divided by Δt², rounding of the
position itself would be an acceleration.

`quasi-static`: no acceleration, and the velocity v = (q₁ - q₀)/Δt of the step.

`dynamic`: the generalised-α scheme of Chung and Hulbert in the form of Arnold and Brüls, which meets the equations of
motion at the end of every step. An auxiliary acceleration a follows the true acceleration A,

    (1 - α_m) a₁ + α_m a₀ = (1 - α_f) A₁ + α_f A₀
    q₁ = q₀ + Δt v₀ + Δt² [(½ - β) a₀ + β a₁],        v₁ = v₀ + Δt [(1 - γ) a₀ + γ a₁]

with the prediction q₀ + Δt v₀ + ½ Δt² a₀, and so a₁ = a₀ + δ/(β Δt²). Here α_m = (2ρ - 1)/(ρ + 1), α_f = ρ/(ρ + 1), γ =
½ + α_f - α_m, β = ¼ (γ + ½)². Second order and unconditionally stable; the fastest oscillation loses the fraction 1 - ρ
in every step, slow ones keep their energy.

`dynamic` at or just before a contact: implicit Euler steps, v₁ = (q₁ - q₀)/Δt and A₁ = (v₁ - v₀)/Δt. A closing gap
stops in the next step: an impact without rebound, and no force that alternates between steps as in a second-order
scheme (L. Paoli and M. Schatzman, SIAM J. Numer. Anal. 40 (2002) 702).
"""

from collections.abc import Callable
from typing import NamedTuple

from martensite.kernels.namespace import Namespace, Scalar

Numbers = tuple[Scalar, ...]
SHORTEST = 1e-12
"""Shortest time step [s]."""


class Motion(NamedTuple):
    """Position, velocity and acceleration, one value per coordinate."""

    position: Numbers
    velocity: Numbers
    acceleration: Numbers


class MotionHistory(NamedTuple):
    """Motion with memory; empty accelerations without inertia."""

    position: Numbers
    velocity: Numbers
    acceleration: Numbers = ()
    smoothed: Numbers = ()
    """Auxiliary acceleration."""

    def motion(self) -> Motion:
        """Return the present motion."""
        rest = (0.0,) * len(self.position)
        return Motion(self.position, self.velocity, self.acceleration or rest)


Scheme = Callable[[Numbers], MotionHistory]
"""Motion after a step, from the offsets of the final position from `predict_position`."""


def predict_position(course: MotionHistory, dt: Scalar) -> Numbers:
    """Return the position after dt [s] at constant acceleration; without inertia, the present position."""
    if not course.acceleration:
        return course.position
    rows = zip(course.position, course.velocity, course.smoothed, strict=True)
    return tuple(q + dt * (v + (0.5 * dt) * a) for q, v, a in rows)


def quasi_static(xp: Namespace, course: MotionHistory, dt: Scalar) -> Scheme:
    """Return the scheme without inertia."""
    rate = 1.0 / xp.maximum(dt, SHORTEST)

    def after(offsets: Numbers) -> MotionHistory:
        position = tuple(q0 + d for q0, d in zip(course.position, offsets, strict=True))
        return MotionHistory(position, tuple(rate * d for d in offsets))

    return after


def move_dynamically(xp: Namespace, course: MotionHistory, dt: Scalar, rho: Scalar) -> Scheme:
    """Return the generalised-α scheme."""
    alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
    gamma = 0.5 + alpha_f - alpha_m
    beta = 0.25 * (gamma + 0.5) * (gamma + 0.5)
    ahead, dt = predict_position(course, dt), xp.maximum(dt, SHORTEST)
    per, share = 1.0 / (beta * dt * dt), 1.0 / (1.0 - alpha_f)

    def after(offsets: Numbers) -> MotionHistory:
        position = tuple(q + d for q, d in zip(ahead, offsets, strict=True))
        velocity: list[Scalar] = []
        acceleration: list[Scalar] = []
        smoothed: list[Scalar] = []
        for d, v0, true0, a0 in zip(offsets, *course[1:], strict=True):
            a = a0 + per * d
            velocity.append(v0 + dt * ((1.0 - gamma) * a0 + gamma * a))
            acceleration.append(share * ((1.0 - alpha_m) * a + alpha_m * a0 - alpha_f * true0))
            smoothed.append(a)
        return MotionHistory(position, tuple(velocity), tuple(acceleration), tuple(smoothed))

    return after


def move_implicitly(xp: Namespace, course: MotionHistory, dt: Scalar, share: Scalar, usual: Scheme) -> Scheme:
    """Return implicit Euler steps where `share` is 1, and the usual scheme where it is 0."""
    dt = xp.maximum(dt, SHORTEST)
    per = 1.0 / dt

    def after(offsets: Numbers) -> MotionHistory:
        other = usual(offsets)
        rows = zip(offsets, course.smoothed, strict=True)
        changes = [per * d + (0.5 * dt) * a for d, a in rows]
        velocity = [v + change for v, change in zip(course.velocity, changes, strict=True)]
        acceleration = [per * change for change in changes]
        columns = zip((velocity, acceleration, acceleration), other[1:], strict=True)
        mixed = (tuple(share * a + (1.0 - share) * b for a, b in zip(*column, strict=True)) for column in columns)
        return MotionHistory(other.position, *mixed)

    return after
