"""Margins of a loop in discrete time, from its frequency response up to half the sample rate.

    gain margin        1/|L| where L is real and negative: above 1 for raising, below 1 for lowering the gain
    phase margin       π + arg L where |L| = 1
    delay margin       phase margin over frequency, the largest additional delay; 0 for an unstable loop
    modulus margin     min |1 + L| = 1/M_s, the distance to -1; M_s is the largest sensitivity

Source: Åström and Murray (2008), section 9.3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from martensite.identify.chains.linear_system import LinearSystem
from martensite.signals.sampling.sampled import Numbers

POINTS, DECADES = 600, 5.0
"""Number of frequencies, and decades below half the sample rate."""
HALVINGS, ROUNDS, DENSE = 52, 8, 17
"""Bisections of a crossing; rounds and frequencies of the search for the smallest distance to -1."""
INSIDE = 1e-9
"""Distance of a pole from the unit circle that counts as zero."""


@dataclass(frozen=True)
class LoopMargins:
    """Stability margins of a loop."""

    stable: bool
    gain: float
    """Smallest gain margin above 1; infinite without a crossing."""
    least_gain: float
    """Largest gain margin below 1; 0 without a crossing."""
    phase: float
    """Phase margin of the smallest size [rad]; infinite if the gain never crosses 1."""
    crossover: float
    """Its frequency [rad/s]."""
    delay: float
    """Delay margin [s]."""
    modulus: float

    @property
    def sensitivity(self) -> float:
        """Return M_s."""
        return 1.0 / max(self.modulus, 1e-12)


def list_frequencies(interval: float) -> Numbers:
    """Return the frequencies up to half the sample rate [rad/s]."""
    most = np.pi / interval
    return np.geomspace(most * 10.0**-DECADES, most, POINTS)


def evaluate_response(loop: LinearSystem, omega: Numbers) -> Numbers:
    """Return L at frequencies [rad/s] of a system with one input and one output."""
    fraction = np.minimum(np.asarray(omega) * loop.interval / (2.0 * np.pi), 0.5)
    return loop.frequency_response(fraction / loop.interval)[:, 0, 0]


def closed_poles(loop: LinearSystem) -> Numbers:
    """Return the poles of the closed loop in the z plane."""
    slim = loop.reduce_states()
    return np.linalg.eigvals(slim.a - slim.b @ slim.c / (1.0 + slim.d[0, 0]))


def compute_margins(loop: LinearSystem) -> LoopMargins:
    """Return the margins of a loop L with one input and one output, closed by u = -y."""
    slim = loop.reduce_states()
    omega = list_frequencies(loop.interval)
    response = evaluate_response(slim, omega)
    crossings = _refine_zeros(slim, omega, lambda value: np.log(np.abs(value) + 1e-300))
    phases = [(float(np.angle(-value)), w) for w, value in crossings]
    reals = [value.real for _, value in _refine_zeros(slim, omega, np.imag)] + [response[-1].real]
    gains = [-1.0 / float(real) for real in reals if real < 0.0]
    phase, crossover = min(phases, key=lambda pair: abs(pair[0]), default=(np.inf, np.nan))
    delays = [(p % (2.0 * np.pi)) / w for p, w in phases]
    stable = bool(np.all(np.abs(closed_poles(slim)) < 1.0 - INSIDE))
    return LoopMargins(
        stable,
        min((g for g in gains if g > 1.0), default=np.inf),
        max((g for g in gains if g <= 1.0), default=0.0),
        float(phase),
        float(crossover),
        min(delays, default=np.inf) if stable else 0.0,
        _refine_distance(slim, omega, response),
    )


def _refine_zeros(
    loop: LinearSystem, omega: Numbers, function: Callable[[Numbers], Numbers]
) -> list[tuple[float, complex]]:
    """Return the frequencies at which a function of L is 0, and L there, by vectorised bisection."""
    values = function(evaluate_response(loop, omega))
    turns = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    if not len(turns):
        return []
    low, high, below = omega[turns], omega[turns + 1], values[turns]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        same = function(evaluate_response(loop, middle)) * below > 0.0
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    middle = 0.5 * (low + high)
    return list(zip(middle.tolist(), evaluate_response(loop, middle).tolist(), strict=True))


def _refine_distance(loop: LinearSystem, omega: Numbers, response: Numbers) -> float:
    """Return the least |1 + L| by repeated refinement around the nearest frequency."""
    distance = np.abs(1.0 + response)
    for _ in range(ROUNDS):
        k = int(np.argmin(distance))
        omega = np.linspace(omega[max(k - 1, 0)], omega[min(k + 1, len(omega) - 1)], DENSE)
        distance = np.abs(1.0 + evaluate_response(loop, omega))
    return float(distance.min())
