"""The platform with one hot spring, by a root and an integral: no time steps, no shared code.

Spring 0 at (0, r) is heated by an electrical power, springs 1 and 2 at y = -r/2 stay cold, and
the plate turns about X without inertia or damping. On heating the path does not depend on the
power: with θ from 0 to π as parameter

    ξ = cos²(θ/2),   α from Σ F_i dL_i/dα = 0,   T = A_s + σ/C_A + θ/a_A,   a_A = π/(A_f - A_s)
    t(θ) = t₀ + ∫ [m c dT/dθ + ½ m Δh sin θ]/[P(ξ) - h S (T - T_a)] dθ

with t₀ the time of warming up to T(0). Written for this project from the published equations
(Ranjith Pillai, Murali and Gopal, 2018) as corrected; temperatures in °C, everything else in SI.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
PANELS = 4
"""Of the integral over θ."""


@dataclass(frozen=True)
class Platform:
    """Numbers of plate, springs, kinetics, heat and supply."""

    side: float = 0.100
    height: float = 0.060
    wire: float = 0.75e-3
    coil: float = 5.25e-3
    turns: float = 20.0
    closed: float = 15e-3
    shear_hot: float = 26.9e9
    shear_cold: float = 17e9
    start: float = 42.6
    finish: float = 50.3
    slope: float = 6e6
    mass: float = 1e-3
    capacity: float = 837.0
    latent: float = 24.2e3
    film: float = 150.0
    ambient: float = 25.0
    hot_ohms: float = 0.7246
    cold_ohms: float = 0.8197
    series: float = 0.0
    limit: float = math.inf
    volts: float = 5.0

    def force(self, fraction: float, length: float) -> float:
        """k(ξ) (L - L_A) - k_M (L_0 - L_A) ξ [N]."""
        rates = [g * self.wire**4 / (8 * self.turns * self.coil**3) for g in (self.shear_hot, self.shear_cold)]
        rate = rates[0] + fraction * (rates[1] - rates[0])
        return rate * (length - self.closed) - rates[1] * (self.height - self.closed) * fraction

    def leg(self, angle: float, y: float) -> tuple[float, float]:
        """Length [m] of the spring at y on a plate turned about X, and its slope [m/rad]."""
        s, c = math.sin(angle), math.cos(angle)
        h = self.height
        length = math.sqrt(2 * y * y * (1 - c) - 2 * h * y * s + h * h)
        return length, (y * y * s - h * y * c) / length

    def torque(self, angle: float, fraction: float) -> float:
        """Of all springs [N m]."""
        r = self.side / math.sqrt(3.0)
        found = 0.0
        for y, state, count in ((r, fraction, 1), (-r / 2, 1.0, 2)):
            length, slope = self.leg(angle, y)
            found -= count * self.force(state, length) * slope
        return found

    def angle(self, fraction: float) -> float:
        """At which the springs balance [rad]."""
        return bisected(lambda a: -self.torque(a, fraction), -0.1, 0.8)

    def contraction(self, fraction: float) -> float:
        """Of spring 0 [m]."""
        length, _ = self.leg(self.angle(fraction), self.side / math.sqrt(3.0))
        return self.height - length

    def temperature(self, theta: float) -> float:
        """On the heating path [°C]."""
        fraction = math.cos(theta / 2) ** 2
        length = self.height - self.contraction(fraction)
        shear = 8 * self.force(fraction, length) * self.coil / (math.pi * self.wire**3)
        shift = math.sqrt(3.0) * shear / self.slope
        return self.start + shift + theta * (self.finish - self.start) / math.pi

    def power(self, fraction: float) -> float:
        """I² R [W]."""
        ohms = self.hot_ohms + fraction * (self.cold_ohms - self.hot_ohms)
        current = min(self.volts / (ohms + self.series), self.limit)
        return current * current * ohms

    def conductance(self) -> float:
        """h S [W/K]."""
        return self.film * math.pi * self.wire * math.pi * self.coil * self.turns

    def surplus(self, theta: float) -> float:
        """Power less heat loss [W]; where it vanishes the platform stalls."""
        loss = self.conductance() * (self.temperature(theta) - self.ambient)
        return self.power(math.cos(theta / 2) ** 2) - loss

    def theta_at(self, angle: float) -> float:
        """The parameter at which the plate has turned by an angle [rad]."""
        return bisected(lambda t: self.angle(math.cos(t / 2) ** 2) - angle, 0.0, math.pi)

    def arrival(self, angle: float) -> float:
        """Time to an angle [rad] from rest [s]; infinite if the platform stalls before."""
        heat, loss = self.mass * self.capacity, self.conductance()
        warm = loss * (self.start - self.ambient) / self.power(1.0)
        time = -heat / loss * math.log(1 - warm) if warm < 1 else math.inf
        edges = np.linspace(0.0, self.theta_at(angle), PANELS + 1)
        if min(self.surplus(float(edge)) for edge in edges) <= 0.0:
            return math.inf
        for low, high in pairwise(edges):
            for node, weight in zip(NODES, WEIGHTS, strict=True):
                theta = 0.5 * (low + high) + 0.5 * (high - low) * float(node)
                slope = (self.temperature(theta + 1e-5) - self.temperature(theta - 1e-5)) / 2e-5
                taken = heat * slope + 0.5 * self.mass * self.latent * math.sin(theta)
                time += 0.5 * (high - low) * weight * taken / self.surplus(theta)
        return float(time)


def bisected(rising: Callable[[float], float], low: float, high: float) -> float:
    """Where a rising function vanishes."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if rising(middle) > 0.0 else (middle, high)
    return 0.5 * (low + high)
