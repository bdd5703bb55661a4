"""Parts of a bench, by name, and their memories."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

from martensite.actuators.assembly import Members
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, Parametrised, param, part, text
from martensite.base.registry import Registry
from martensite.control.controllers.base import AbstractController
from martensite.control.controllers.conditioning import ManualInput
from martensite.control.faults.base import AbstractFault
from martensite.control.observers.base import AbstractObserver
from martensite.control.sensors.base import SENSORS, AbstractSensor, Column
from martensite.kernels.namespace import Flag, Namespace, Scalar

PERIOD_TOLERANCE = 1e-9
"""Part of a period that is rounding."""
WORST = 4.0
"""Jitters beyond which no reading is later."""
NEVER = 1e9
"""Age of a reading that was never made [s]."""


class Sensed(NamedTuple):
    """Memory of a sensor on a bench."""

    inner: tuple[Scalar, ...]
    """Memory of the sensor itself."""
    held: Scalar
    """Last reading of the sensor."""
    elapsed: Scalar
    """Time since it was made [s]."""
    past: tuple[Scalar, ...]
    """Readings of this and the last periods, latest first."""
    ages: tuple[Scalar, ...]
    """Their ages then [s]."""
    travels: tuple[Scalar, ...]
    """Remaining travel times of the readings [s]."""
    reading: Scalar
    """Last reading that has arrived."""
    age: Scalar
    """And how old it is [s]."""


class MountedSensor(Parametrised):
    """A sensor in its place.

        truth → lag and noise → rounding → held until the next sample → late by delay + jitter n

    Lag, noise and rounding are those of the sensor itself. `sample_time` is the time between its readings, a whole
    number of periods of the bench in the end: a reading is taken in the first period after that time. While the sensor
    has no valid input, the last reading is held. Each reading travels for `delay` + `jitter` n, with an independent
    standard normal number n that is limited to ±4; a negative travel time is 0. In every period the newest reading
    that has arrived is used. A reading that is overtaken on its way is lost.
    """

    sensor: AbstractSensor = part("the sensor", SENSORS)
    of: str | tuple[str, ...] = text("outputs that it looks at; its own choice if none", default=())
    sample_time: Number = param("s", "time between its readings", low=0.0, default=0.0)
    delay: Number = param("s", "how late a reading arrives", low=0.0, default=0.0)
    jitter: Number = param("s", "standard deviation of the delay", low=0.0, default=0.0)

    def check(self) -> None:
        """Raise `ParameterError` unless it is told as many outputs as the sensor looks at."""
        wanted, given = self.sensor.sees, self.sees()
        if len(given) != len(wanted):
            raise ParameterError(
                f"Sensor `{self.sensor.registered_name}` looks at {' and '.join(wanted)}: `of` "
                f"must name {len(wanted)}, but is {', '.join(given)}."
            )

    def sees(self) -> tuple[str, ...]:
        """Return the outputs that it looks at."""
        given = (self.of,) if isinstance(self.of, str) else self.of
        return given or self.sensor.sees

    def count_delayed(self, period: float, later: float = 0.0) -> int:
        """Return the readings to be kept for the delay, and for a fault that makes it longer [s]."""
        return 1 + math.ceil((self.delay + WORST * self.jitter + later) / period - PERIOD_TOLERANCE)

    def rest(self, xp: Namespace, truth: Mapping[str, Scalar], noise: Scalar, kept: int) -> Sensed:
        """Return the first reading, made at rest; it has been the same for long."""
        seen = [truth[name] for name in self.sees()]
        inner = self.sensor.rest(xp, seen)
        value, inner = self.sensor.reading(xp, inner, seen, noise, 0.0)
        age = xp.where(self.sensor.valid(xp, seen), 0.0, NEVER)
        past, ages, travels = ((one,) * kept for one in (value, age, self.delay))
        return Sensed(tuple(inner), value, age, past, ages, travels, value, age)

    def step(
        self,
        xp: Namespace,
        before: Sensed,
        truth: Mapping[str, Scalar],
        numbers: tuple[Scalar, Scalar],
        period: Scalar,
        disturbed: Disturbed,
    ) -> Sensed:
        """Return the memory a period [s] later, with normal numbers for noise and jitter."""
        noise, late = numbers
        seen = [truth[name] for name in self.sees()]
        value, inner = self.sensor.reading(xp, before.inner, seen, noise, period)
        value = disturbed.reading(xp, value, before.held, noise)
        elapsed = before.elapsed + period
        due = xp.both(self.sensor.valid(xp, seen), elapsed >= self.sample_time - PERIOD_TOLERANCE * period)
        fresh = disturbed.fresh(xp, due)
        held, elapsed = xp.where(fresh, value, before.held), xp.where(fresh, 0.0, elapsed)
        travel = disturbed.travel(xp, xp.clip(late, -WORST, WORST) * self.jitter + self.delay)
        travel = xp.where(fresh, travel, before.travels[0])
        past, ages = (held, *before.past[:-1]), (elapsed, *before.ages[:-1])
        travels = (travel, *before.travels[:-1])
        reading, age = _find_arrived(xp, past, ages, travels, period)
        return Sensed(tuple(inner), held, elapsed, past, ages, travels, reading, age)


def _find_arrived(xp: Namespace, past: Column, ages: Column, travels: Column, period: Scalar) -> tuple[Scalar, Scalar]:
    """Return the newest reading that has arrived, and its age [s]; the oldest one has."""
    oldest = len(past) - 1
    reading, age = past[oldest], ages[oldest] + oldest * period
    for k in range(oldest - 1, -1, -1):
        old = ages[k] + k * period
        there = old >= travels[k] - PERIOD_TOLERANCE * period
        reading, age = xp.where(there, past[k], reading), xp.where(there, old, age)
    return reading, age


class Disturbed:
    """Effect of faults on one sensor."""

    def __init__(self, name: str, faults: Sequence[tuple[AbstractFault, Flag]]) -> None:
        self.name, self.faults = name, faults

    def reading(self, xp: Namespace, reading: Scalar, held: Scalar, noise: Scalar) -> Scalar:
        """Return the reading after every fault; `noise` is the normal number of its noise."""
        for fault, active in self.faults:
            reading = fault.reading(xp, self.name, reading, held, active)
            reading = fault.disturb(xp, self.name, reading, noise, active)
        return reading

    def travel(self, xp: Namespace, travel: Scalar) -> Scalar:
        """Return the travel time of the reading [s], with every fault."""
        for fault, active in self.faults:
            travel = fault.travel(xp, self.name, travel, active)
        return travel

    def fresh(self, xp: Namespace, fresh: Flag) -> Flag:
        """Return whether there is a new reading, after every fault."""
        for fault, active in self.faults:
            fresh = fault.fresh(xp, self.name, fresh, active)
        return fresh


SUPERVISORS: Registry[AbstractSupervisor] = Registry("supervisor", "martensite.control.supervisors", typical="guard")
Named: TypeAlias = Mapping[str, Scalar]
Numbers = dict[str, Scalar]


class SupervisorVerdict(NamedTuple):
    """Decision of a supervisor."""

    signals: dict[str, Scalar]
    """Allowed, by the name of the drive."""
    alarm: Scalar
    """0, or the number of the alarm."""
    memory: Column


class AbstractSupervisor(Parametrised):
    """Interface of a supervisor.

    It sees the signals that controllers (or waveforms) want and all readings with their ages, and answers with the
    signals that are allowed and a number for its alarm, 0 if all is well.
    """

    def reads(self) -> tuple[str, ...]:
        """Return the names of the readings that it needs."""
        return ()

    def drives(self) -> tuple[str, ...]:
        """Return the names of the drives that it speaks of."""
        return ()

    def name_checks(self) -> dict[int, list[str]]:
        """Return the number of an alarm -> names of what raises it."""
        return {}

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """Return the memory before the first sample."""
        return ()

    @abstractmethod
    def judge(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> SupervisorVerdict:
        """Return the signals that are allowed for the next period.

        Args:
            xp: namespace.
            memory: from the period before, or from `rest`.
            wanted: signals by the name of the drive.
            readings: by name, in SI, and the age of each, `NAME.age` [s].
            dt: length of the period [s].
        """


class Sensors(Members[MountedSensor], init=False):
    """Sensors by name: what a controller calls their readings."""

    noun, kind = "sensor", MountedSensor


class Observers(Members[AbstractObserver], init=False):
    """Observers by name."""

    noun, kind = "observer", AbstractObserver


class Controllers(Members[AbstractController], init=False):
    """Controllers by the name of the drive that they have."""

    noun, kind = "controller", AbstractController


class FaultTable(Members[AbstractFault], init=False):
    """Faults by name."""

    noun, kind = "fault", AbstractFault


class ObserverState(NamedTuple):
    """State of an observer."""

    estimates: tuple[Scalar, ...]
    memory: tuple[Scalar, ...]


class Controlling(NamedTuple):
    """State of a controller."""

    wanted: Scalar
    memory: tuple[Scalar, ...]


class BenchState(NamedTuple):
    """All that changes in time."""

    time: Scalar
    plant: Any
    sensors: tuple[Sensed, ...]
    observers: tuple[ObserverState, ...]
    controllers: tuple[Controlling, ...]
    supervisor: tuple[Scalar, ...]


class Inputs(NamedTuple):
    """Inputs of a bench, by destination."""

    references: tuple[Scalar, ...]
    previews: tuple[Scalar, ...]
    """References ahead."""
    hands: tuple[ManualInput | None, ...]
    """Manual inputs, for every controller; None for a controller without a manual mode."""
    free: Numbers
    """Signals of the plant that no controller has."""
    numbers: tuple[tuple[Scalar, Scalar], ...]
    """Normal numbers for noise and jitter of every sensor."""
