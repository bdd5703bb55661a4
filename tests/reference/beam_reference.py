"""The beam, the motor on it and a hot wire at its tip, on one page.

Independent of the package: nothing of it is imported. Written from Lagrange's equations of beam and unbalanced rotor,
the full geometry of a straight wire at an angle, the heat balance of the wire, and Liang and Rogers' cosines with the
modulus of the mixture. Classical Runge–Kutta steps; in each the wire answers to trial positions from its state at the
start, and is advanced once, at the end. Its fraction is the root of ξ = law(σ(ξ), T(ξ)), found by halving.
"""

from __future__ import annotations

from math import cos, pi, sin, sqrt
from typing import NamedTuple

E_A, E_M, EPS_L, SLOPE = 75e9, 28e9, 0.04, 10.3e6
M_F, M_S, A_S, A_F = 315.15, 325.15, 341.15, 351.15
DIAMETER, LENGTH, DENSITY, CAPACITY, LATENT = 375e-6, 0.3313, 6450.0, 837.0, 24.2e3
FILM, AMBIENT, PER_LENGTH, ANGLE = 128.6, 295.15, 8.3, pi / 12
MASS, STIFFNESS, DAMPING, UNBALANCE, RADIUS = 0.1961, 541.0, 0.2335, 0.012, 0.02
ROTOR, FRICTION, CONSTANT, OHMS, HENRYS = 0.82e-4, 8.17e-7, 0.0211, 6.22, 3.1e-3
AREA = pi / 4.0 * DIAMETER**2


class HotWire(NamedTuple):
    """What the wire remembers."""

    fraction: float = 1.0
    temperature: float = AMBIENT
    stress: float = 0.0
    direction: int = 0
    scale: float = 0.0


def stretch(x: float) -> float:
    """Length of the path of the wire with the tip at x [m]."""
    return sqrt((LENGTH * cos(ANGLE)) ** 2 + (LENGTH * sin(ANGLE) + x) ** 2)


def forward_rest(u: float) -> float:
    return 1.0 if u >= M_S else 0.0 if u <= M_F else sin(0.5 * pi * (u - M_F) / (M_S - M_F)) ** 2


def reverse_rest(w: float) -> float:
    return 1.0 if w <= A_S else 0.0 if w >= A_F else cos(0.5 * pi * (w - A_S) / (A_F - A_S)) ** 2


def transform(wire: HotWire, stress: float, temperature: float) -> tuple[float, int, float]:
    """Fraction after a straight move, direction of the branch and its scale; both strips have one slope."""
    before, after = wire.temperature - wire.stress / SLOPE, temperature - stress / SLOPE
    way = -1 if after > before else 1
    rest = reverse_rest if way < 0 else forward_rest
    left = wire.fraction if way < 0 else 1.0 - wire.fraction
    if left <= 0.0 or not rest(after) < rest(before):
        return wire.fraction, wire.direction, wire.scale
    scale = wire.scale if wire.direction == way else left / rest(before)
    now = min(scale * rest(after), left)
    return (now if way < 0 else 1.0 - now), way, scale


def answer(wire: HotWire, strain: float, dt: float, current: float) -> HotWire:
    """The wire at a strain [-] after dt [s] with a current [A]; it never pushes."""
    held, leak = DENSITY * CAPACITY * AREA, pi * DIAMETER * FILM
    quiet = held * wire.temperature + dt * (PER_LENGTH * current**2 - leak * (0.5 * wire.temperature - AMBIENT))

    def state(fraction: float) -> tuple[float, float]:
        released = DENSITY * AREA * LATENT * (fraction - wire.fraction)
        young = E_A + fraction * (E_M - E_A)
        return max(young * (strain - EPS_L * fraction), 0.0), (quiet + released) / (held + 0.5 * dt * leak)

    low, high = 0.0, 1.0
    still = transform(wire, *state(wire.fraction))[0] - wire.fraction  # most moves transform nothing
    if abs(still) < 1e-14:
        low = high = wire.fraction
    elif still > 0.0:
        low = wire.fraction
    else:
        high = wire.fraction
    while high - low > 1e-12:
        middle = 0.5 * (low + high)
        if transform(wire, *state(middle))[0] > middle:
            low = middle
        else:
            high = middle
    fraction = 0.5 * (low + high)
    stress, temperature = state(fraction)
    return HotWire(fraction, temperature, stress, *transform(wire, stress, temperature)[1:])


def rates(y: list[float], stress: float, volts: float) -> list[float]:
    """Of displacement, velocity, angle, speed and current."""
    x, v, angle, speed, current = y
    moment, path = UNBALANCE * RADIUS, stretch(x)
    pull = stress * AREA * (LENGTH * sin(ANGLE) + x) / path
    push = moment * speed**2 * sin(angle) - DAMPING * v - STIFFNESS * x - pull
    torque = CONSTANT * current - FRICTION * speed
    shared, turning = moment * cos(angle), ROTOR + UNBALANCE * RADIUS**2
    share = MASS * turning - shared**2
    return [
        v,
        (push * turning - shared * torque) / share,
        speed,
        (MASS * torque - shared * push) / share,
        (volts - CONSTANT * speed - OHMS * current) / HENRYS,
    ]


def run_beam(
    slack: float, rate: float, duration: float, amperes: float, on: float, step: float
) -> list[tuple[float, float, float]]:
    """Displacement [m], speed of the rotor [rad/s] and temperature of the wire [K] after every step.

    The voltage rises from 0 at a rate [V/s]; the wire is heated by a current from the time `on` [s].
    """
    y, wire, rows = [0.0] * 5, HotWire(), []
    for k in range(round(duration / step)):
        time = k * step
        volts = [rate * (time + share * step) for share in (0.0, 0.5, 1.0)]
        current = amperes if time >= on - 1e-9 else 0.0

        def at(x: float, dt: float, wire: HotWire = wire, current: float = current) -> HotWire:
            return answer(wire, stretch(x) / LENGTH - 1.0 - slack, dt, current)

        one = rates(y, wire.stress, volts[0])
        middle = [a + 0.5 * step * b for a, b in zip(y, one, strict=True)]
        two = rates(middle, at(middle[0], 0.5 * step).stress, volts[1])
        middle = [a + 0.5 * step * b for a, b in zip(y, two, strict=True)]
        three = rates(middle, at(middle[0], 0.5 * step).stress, volts[1])
        end = [a + step * b for a, b in zip(y, three, strict=True)]
        four = rates(end, at(end[0], step).stress, volts[2])
        slopes = zip(y, one, two, three, four, strict=True)
        y = [a + step / 6.0 * (b + 2.0 * c + 2.0 * d + e) for a, b, c, d, e in slopes]
        wire = at(y[0], step)
        rows.append((y[0], y[3], wire.temperature))
    return rows
