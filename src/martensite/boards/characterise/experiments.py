"""Duty cycle profiles that characterise a wire: pulses, staircases, ramps and first-order reversal curves.

Each is a list of levels (time [s], duty cycle), relative to a full duty cycle: the least of the model that transforms
the wire to austenite in the steady state. A profile begins and ends cold.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import SolveError
from martensite.simulate.lanes import Lanes

DUTIES = 40
"""Number of candidates for the full duty cycle."""
AUSTENITE = 0.02
"""Martensite fraction that counts as zero."""
REST = 3.0
"""Rest after a profile, in cooling times."""
STEP = 0.02
"""Step of the model [s]."""


@dataclass(frozen=True)
class DutyCourse:
    """Levels of a duty cycle."""

    name: str
    levels: tuple[tuple[float, float], ...]
    """Time [s] and duty cycle of each level."""

    @property
    def duration(self) -> float:
        """Return the time of all levels [s]."""
        return sum(length for length, _ in self.levels)

    def scaled(self, factor: float) -> DutyCourse:
        """Return the profile with all duty cycles multiplied, at most 1."""
        levels = tuple((length, min(duty * factor, 1.0)) for length, duty in self.levels)
        return DutyCourse(self.name, levels)

    def sample(self, step: float) -> NDArray[np.float64]:
        """Return the duty cycle in every step [s]."""
        return np.concatenate([np.full(max(1, round(length / step)), duty) for length, duty in self.levels])


@dataclass(frozen=True)
class WirePace:
    """Full duty cycle and speed of a wire of the model."""

    full: float
    """Duty cycle with a steady state of austenite."""
    rise: float
    """Time of heating to austenite [s]."""
    fall: float
    """Time of cooling to martensite [s]."""


def measure_pace(plant: AbstractSystem, longest: float = 60.0) -> WirePace:
    """Return full duty cycle and times of the model of a plant of one wire.

    Raises:
        SolveError: no duty cycle gives austenite in the longest time [s].
    """
    duties = np.linspace(1.0 / DUTIES, 1.0, DUTIES)
    lanes = Lanes(plant, DUTIES)
    lanes.reset(np.zeros((1, DUTIES)))
    place, steps = lanes.names.index("martensite_fraction"), round(longest / STEP)
    up = lanes.advance(np.broadcast_to(duties, (steps, 1, DUTIES)), STEP)[:, place, :]
    strong = np.flatnonzero(up[-1] < AUSTENITE)
    if not len(strong):
        raise SolveError(
            f"No duty cycle transforms the wire of the model within {longest:g} s. Use a higher supply voltage."
        )
    k = int(strong[0])
    down = lanes.advance(np.zeros((steps, 1, DUTIES)), STEP)[:, place, k]
    cold = np.flatnonzero(down > 1.0 - AUSTENITE)
    fall = STEP * float(cold[0]) if len(cold) else longest
    k = min(k + 1, DUTIES - 1)  # a step more, so that it does not creep there
    return WirePace(float(duties[k]), STEP * float(np.argmax(up[:, k] < AUSTENITE)), fall)


def list_courses(pace: WirePace) -> Iterator[DutyCourse]:
    """Yield all profiles for a wire."""
    full, rise, rest = pace.full, pace.rise, (REST * pace.fall, 0.0)
    for fraction in (0.4, 0.7, 1.0):
        yield DutyCourse(f"pulse {fraction:g}", ((fraction * rise, full), rest))
    yield DutyCourse("short pulse", ((0.3 * rise, min(1.0, 2.0 * full)), rest))
    shares = np.linspace(0.2, 1.0, 5)
    yield DutyCourse("staircase", (*_hold_shares([*shares, *shares[-2::-1]], 0.8 * rise, full), rest))
    ramp = np.linspace(0.0, 1.0, 20)
    yield DutyCourse("ramp", (*_hold_shares([*ramp, *ramp[::-1]], 0.2 * rise, full), rest))
    for turn in (0.6, 0.75, 0.9):
        course = [1.0, 0.4, turn, 0.3, 1.0]
        yield DutyCourse(f"reversal {turn:g}", (*_hold_shares(course, rise, full), rest))


def _hold_shares(shares: Sequence[float], length: float, full: float) -> Iterator[tuple[float, float]]:
    for fraction in shares:
        yield length, float(fraction) * full
