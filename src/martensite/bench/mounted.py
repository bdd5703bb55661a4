"""A sensor on a bench: what it looks at, how often, and how late what it says arrives.

    truth → lag and noise → rounding → held until the next sample → late by delay + jitter n

Lag, noise and rounding are those of the sensor itself. `sample_time` is the time between its
readings, a whole number of periods of the bench in the end: one is made in the first period in
which so much time has gone by. Readings travel: in every period the latest one counts that is at
least `delay` + `jitter` n old, with a standard normal number n drawn anew in every period, not
below 0 and never beyond the delay by more than four times the jitter.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from martensite.bench.faults.base import AbstractFault
from martensite.parameters import Parametrised, param, part, text
from martensite.runtimes.namespace import Flag, Namespace, Scalar
from martensite.sensors.base import SENSORS, AbstractSensor

HAIR = 1e-9
"""Part of a period that is rounding."""
WORST = 4.0
"""Jitters beyond which no reading is later."""


class Sensed(NamedTuple):
    """What a sensor on a bench remembers."""

    inner: tuple[Scalar, ...]
    """Of the sensor itself."""
    held: Scalar
    """Its last reading."""
    elapsed: Scalar
    """Time since it was made [s]."""
    past: tuple[Scalar, ...]
    """Readings of this and the last periods, latest first."""
    ages: tuple[Scalar, ...]
    """Their ages then [s]."""
    reading: Scalar
    """What has arrived."""
    age: Scalar
    """And how old it is [s]."""


class Mounted(Parametrised):
    """A sensor in its place."""

    sensor: AbstractSensor = part("the sensor", SENSORS)
    of: tuple[str, ...] = text("outputs that it looks at; its own choice if none", default=())
    sample_time: Scalar = param("s", "time between its readings", low=0.0, default=0.0)
    delay: Scalar = param("s", "how late a reading arrives", low=0.0, default=0.0)
    jitter: Scalar = param("s", "standard deviation of the delay", low=0.0, default=0.0)

    def sees(self) -> tuple[str, ...]:
        """Outputs that it looks at."""
        given = (self.of,) if isinstance(self.of, str) else self.of
        return given or self.sensor.sees

    def kept(self, period: float) -> int:
        """Readings to be kept for the delay."""
        return 1 + math.ceil((self.delay + WORST * self.jitter) / period - HAIR)

    def rest(self, xp: Namespace, truth: Mapping[str, Scalar], noise: Scalar, kept: int) -> Sensed:
        """The first reading, made at rest; it has been the same for long."""
        seen = [truth[name] for name in self.sees()]
        inner = self.sensor.rest(xp, seen)
        value, inner = self.sensor.step(xp, inner, seen, noise, 0.0)
        value = self._rounded(xp, value)
        zeros = (0.0,) * kept
        return Sensed(tuple(inner), value, 0.0, (value,) * kept, zeros, value, 0.0)

    def step(
        self, xp: Namespace, before: Sensed, truth: Mapping[str, Scalar],
        numbers: tuple[Scalar, Scalar], period: Scalar, disturbed: Disturbed,
    ) -> Sensed:  # fmt: skip
        """What it says a period [s] later, with normal numbers for noise and jitter."""
        noise, late = numbers
        seen = [truth[name] for name in self.sees()]
        value, inner = self.sensor.step(xp, before.inner, seen, noise, period)
        value = disturbed.reading(xp, self._rounded(xp, value), before.held)
        elapsed = before.elapsed + period
        fresh = disturbed.fresh(xp, elapsed >= self.sample_time - HAIR * period)
        held = xp.where(fresh, value, before.held)
        elapsed = xp.where(fresh, 0.0, elapsed)
        past, ages = (held, *before.past[:-1]), (elapsed, *before.ages[:-1])
        least = xp.clip(late, -WORST, WORST) * self.jitter + self.delay
        reading, age = past[-1], ages[-1] + (len(past) - 1) * period
        for k in range(len(past) - 2, -1, -1):
            arrived = k * period >= least - HAIR * period
            reading = xp.where(arrived, past[k], reading)
            age = xp.where(arrived, ages[k] + k * period, age)
        return Sensed(tuple(inner), held, elapsed, past, ages, reading, age)

    def _rounded(self, xp: Namespace, value: Scalar) -> Scalar:
        """To the nearest step of the resolution, if there is one."""
        least = self.sensor.resolution
        some = least > 0.0
        steps = xp.nearest(value / xp.where(some, least, 1.0))
        return xp.where(some, steps * least, value)


class Disturbed:
    """How faults disturb one sensor."""

    def __init__(self, name: str, faults: Sequence[tuple[AbstractFault, Flag]]) -> None:
        self.name, self.faults = name, faults

    def reading(self, xp: Namespace, reading: Scalar, held: Scalar) -> Scalar:
        """What it says, after every fault."""
        for fault, active in self.faults:
            reading = fault.reading(xp, self.name, reading, held, active)
        return reading

    def fresh(self, xp: Namespace, fresh: Flag) -> Flag:
        """Whether there is a new reading, after every fault."""
        for fault, active in self.faults:
            fresh = fault.fresh(xp, self.name, fresh, active)
        return fresh
