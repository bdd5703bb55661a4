r"""Motions of a mechanism over a step: positions, velocities and accelerations that fit together.

Whatever the scheme, velocity and acceleration at the end of a step are straight lines in the
position there, so the step is one system of equations. Its unknowns are the offsets δ of the position
from its prediction. The position itself would not do: divided by Δt², its rounding would be an acceleration.

`quasi-static`: no acceleration, and the velocity is that of the step, v = (q₁ - q₀)/Δt.

`dynamic`: the generalised-α scheme of Chung and Hulbert in the form of Arnold and Brüls, which
meets the equations of motion at the end of every step. An auxiliary acceleration a follows the
true one A,

    (1 - α_m) a₁ + α_m a₀ = (1 - α_f) A₁ + α_f A₀
    q₁ = q₀ + Δt v₀ + Δt² [(½ - β) a₀ + β a₁],        v₁ = v₀ + Δt [(1 - γ) a₀ + γ a₁]

with the prediction q₀ + Δt v₀ + ½ Δt² a₀, and so a₁ = a₀ + δ/(β Δt²). Here α_m = (2ρ - 1)/(ρ + 1),
α_f = ρ/(ρ + 1), γ = ½ + α_f - α_m, β = ¼ (γ + ½)². Second order and unconditionally stable; a
fraction 1 - ρ of the fastest oscillation is lost in every step, slow ones keep their energy.

`dynamic`, where a unilateral constraint pushes or would be overrun: implicit Euler steps, v₁ = (q₁ - q₀)/Δt and
A₁ = (v₁ - v₀)/Δt. What closes a gap stands still in the next step: an impact without rebound, and no force that turns
from step to step as in a scheme of second order (L. Paoli and M. Schatzman, SIAM J. Numer. Anal. 40 (2002) 702).
"""

from collections.abc import Callable
from typing import NamedTuple

from martensite.kernels.namespace import Namespace, Scalar

Numbers = tuple[Scalar, ...]
SHORTEST = 1e-12
"""Step [s] below which a step is none."""


class Motion(NamedTuple):
    """Position and motion of a mechanism, one number per coordinate."""

    position: Numbers
    velocity: Numbers
    acceleration: Numbers


class MotionHistory(NamedTuple):
    """Memory of the motion of a mechanism; a quasi-static one has no acceleration."""

    position: Numbers
    velocity: Numbers
    acceleration: Numbers = ()
    smoothed: Numbers = ()
    """The auxiliary acceleration."""

    def motion(self) -> Motion:
        """Return the motion now."""
        rest = (0.0,) * len(self.position)
        return Motion(self.position, self.velocity, self.acceleration or rest)


Scheme = Callable[[Numbers], MotionHistory]
"""The course after a step, from the offsets of the position at its end from `predict_position`."""


def predict_position(course: MotionHistory, dt: Scalar) -> Numbers:
    """Return the position after a step of dt [s] if the acceleration stays; without inertia, if nothing moves."""
    if not course.acceleration:
        return course.position
    rows = zip(course.position, course.velocity, course.smoothed, strict=True)
    return tuple(q + dt * (v + (0.5 * dt) * a) for q, v, a in rows)


def quasi_static(xp: Namespace, course: MotionHistory, dt: Scalar) -> Scheme:
    """Return the motion without inertia."""
    rate = 1.0 / xp.maximum(dt, SHORTEST)

    def after(offsets: Numbers) -> MotionHistory:
        position = tuple(q0 + d for q0, d in zip(course.position, offsets, strict=True))
        return MotionHistory(position, tuple(rate * d for d in offsets))

    return after


def move_dynamically(xp: Namespace, course: MotionHistory, dt: Scalar, rho: Scalar) -> Scheme:
    """Return the motion with inertia, by the generalised-α scheme."""
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
    """Return motion with inertia by implicit Euler steps where `share` is 1, and by the usual scheme where it is 0."""
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
