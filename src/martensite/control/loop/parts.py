"""Parts of a bench by name, and their memories."""

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
"""Fraction of a period that is rounding."""
WORST = 4.0
"""Largest jitter over its standard deviation."""
NEVER = 1e9
"""Age before the first reading [s]."""


class SensorState(NamedTuple):
    """Memory of a sensor on a bench."""

    inner: tuple[Scalar, ...]
    held: Scalar
    """Last reading of the sensor."""
    elapsed: Scalar
    """Time since the last reading [s]."""
    past: tuple[Scalar, ...]
    """Readings of this and the last periods, newest first."""
    ages: tuple[Scalar, ...]
    """Ages of these readings when they were stored [s]."""
    travels: tuple[Scalar, ...]
    """Delays of these readings [s]."""
    reading: Scalar
    """Newest reading that has arrived."""
    age: Scalar
    """Its age [s]."""


class MountedSensor(Parametrised):
    """A sensor on a bench.

        truth → lag and noise → rounding → held until the next sample → delay + jitter n

    Lag, noise and rounding belong to the sensor. `sample_time` is rounded up to whole periods of the bench. Without a
    valid input the last reading is held. Each reading is late by `delay` + `jitter` n, at least 0, with an independent
    standard normal number n that is limited to ±4. In every period the newest reading that has arrived is used; a
    reading that is overtaken is lost.
    """

    sensor: AbstractSensor = part("the sensor", SENSORS)
    of: str | tuple[str, ...] = text("measured outputs; default: those of the sensor", default=())
    sample_time: Number = param("s", "time between readings", low=0.0, default=0.0)
    delay: Number = param("s", "delay of a reading", low=0.0, default=0.0)
    jitter: Number = param("s", "standard deviation of the delay", low=0.0, default=0.0)

    def check(self) -> None:
        wanted, outputs = self.sensor.sees, self.sees()
        if len(outputs) != len(wanted):
            raise ParameterError(
                f"Sensor `{self.sensor.registered_name}` looks at {' and '.join(wanted)}: `of` "
                f"must name {len(wanted)}, but is {', '.join(outputs)}."
            )

    def sees(self) -> tuple[str, ...]:
        """Return the measured outputs."""
        outputs = (self.of,) if isinstance(self.of, str) else self.of
        return outputs or self.sensor.sees

    def count_delayed(self, period: float, later: float = 0.0) -> int:
        """Return the number of readings to store for the delay, and for a fault that adds `later` [s]."""
        return 1 + math.ceil((self.delay + WORST * self.jitter + later) / period - PERIOD_TOLERANCE)

    def rest(self, xp: Namespace, truth: Mapping[str, Scalar], noise: Scalar, count: int) -> SensorState:
        """Return the memory in the steady state, with a first reading."""
        signals = [truth[name] for name in self.sees()]
        inner = self.sensor.rest(xp, signals)
        value, inner = self.sensor.reading(xp, inner, signals, noise, 0.0)
        age = xp.where(self.sensor.valid(xp, signals), 0.0, NEVER)
        past, ages, travels = ((one,) * count for one in (value, age, self.delay))
        return SensorState(tuple(inner), value, age, past, ages, travels, value, age)

    def step(
        self,
        xp: Namespace,
        before: SensorState,
        truth: Mapping[str, Scalar],
        numbers: tuple[Scalar, Scalar],
        period: Scalar,
        disturbed: SensorFaults,
    ) -> SensorState:
        """Return the memory after a period [s], with normal numbers for noise and jitter."""
        noise, late = numbers
        signals = [truth[name] for name in self.sees()]
        value, inner = self.sensor.reading(xp, before.inner, signals, noise, period)
        value = disturbed.reading(xp, value, before.held, noise)
        elapsed = before.elapsed + period
        due = xp.both(self.sensor.valid(xp, signals), elapsed >= self.sample_time - PERIOD_TOLERANCE * period)
        fresh = disturbed.fresh(xp, due)
        sample, elapsed = xp.where(fresh, value, before.held), xp.where(fresh, 0.0, elapsed)
        travel = disturbed.travel(xp, xp.clip(late, -WORST, WORST) * self.jitter + self.delay)
        travel = xp.where(fresh, travel, before.travels[0])
        past, ages = (sample, *before.past[:-1]), (elapsed, *before.ages[:-1])
        travels = (travel, *before.travels[:-1])
        reading, age = _find_arrived(xp, past, ages, travels, period)
        return SensorState(tuple(inner), sample, elapsed, past, ages, travels, reading, age)


def _find_arrived(xp: Namespace, past: Column, ages: Column, travels: Column, period: Scalar) -> tuple[Scalar, Scalar]:
    """Return the newest reading that has arrived, and its age [s]."""
    oldest = len(past) - 1
    reading, age = past[oldest], ages[oldest] + oldest * period
    for k in range(oldest - 1, -1, -1):
        old = ages[k] + k * period
        there = old >= travels[k] - PERIOD_TOLERANCE * period
        reading, age = xp.where(there, past[k], reading), xp.where(there, old, age)
    return reading, age


class SensorFaults:
    """Effect of all faults on one sensor."""

    def __init__(self, name: str, faults: Sequence[tuple[AbstractFault, Flag]]) -> None:
        self.name, self.faults = name, faults

    def reading(self, xp: Namespace, reading: Scalar, last_reading: Scalar, noise: Scalar) -> Scalar:
        """Return the reading after every fault; `noise` is its normal number."""
        for fault, active in self.faults:
            reading = fault.reading(xp, self.name, reading, last_reading, active)
            reading = fault.disturb(xp, self.name, reading, noise, active)
        return reading

    def travel(self, xp: Namespace, travel: Scalar) -> Scalar:
        """Return the delay of the reading after every fault [s]."""
        for fault, active in self.faults:
            travel = fault.travel(xp, self.name, travel, active)
        return travel

    def fresh(self, xp: Namespace, fresh: Flag) -> Flag:
        """Return whether there is a new reading after every fault."""
        for fault, active in self.faults:
            fresh = fault.fresh(xp, self.name, fresh, active)
        return fresh


SUPERVISORS: Registry[AbstractSupervisor] = Registry("supervisor", "martensite.control.supervisors", typical="guard")
Named: TypeAlias = Mapping[str, Scalar]
Numbers = dict[str, Scalar]


class SupervisorVerdict(NamedTuple):
    """Decision of a supervisor."""

    signals: dict[str, Scalar]
    """Allowed signals by drive."""
    alarm: Scalar
    memory: Column


class AbstractSupervisor(Parametrised):
    """Interface of a supervisor.

    It sees the wanted signals and all readings with their ages, and returns the allowed signals and an alarm number.
    """

    def reads(self) -> tuple[str, ...]:
        """Return the names of the readings that it needs."""
        return ()

    def drives(self) -> tuple[str, ...]:
        """Return the names of the drives that it uses."""
        return ()

    def name_checks(self) -> dict[int, list[str]]:
        """Return the names of checks by alarm number."""
        return {}

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """Return the memory before the first sample."""
        return ()

    @abstractmethod
    def judge(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> SupervisorVerdict:
        """Return the allowed signals of the next period.

        Args:
            xp: namespace.
            memory: memory after the last period, or from `rest`.
            wanted: signals by the name of the drive.
            readings: readings by name, in SI, and the age of each, `NAME.age` [s].
            dt: sample period [s].
        """


class Sensors(Members[MountedSensor], init=False):
    """Sensors by the names of their readings."""

    noun, kind = "sensor", MountedSensor


class Observers(Members[AbstractObserver], init=False):
    """Observers by name."""

    noun, kind = "observer", AbstractObserver


class Controllers(Members[AbstractController], init=False):
    """Controllers by the name of their drive."""

    noun, kind = "controller", AbstractController


class FaultTable(Members[AbstractFault], init=False):
    """Faults by name."""

    noun, kind = "fault", AbstractFault


class ObserverState(NamedTuple):
    """State of an observer."""

    estimates: tuple[Scalar, ...]
    memory: tuple[Scalar, ...]


class ControllerState(NamedTuple):
    """State of a controller."""

    wanted: Scalar
    memory: tuple[Scalar, ...]


class BenchState(NamedTuple):
    """State of a bench."""

    time: Scalar
    plant: Any
    sensors: tuple[SensorState, ...]
    observers: tuple[ObserverState, ...]
    controllers: tuple[ControllerState, ...]
    supervisor: tuple[Scalar, ...]


class Inputs(NamedTuple):
    """Inputs of a bench, by destination."""

    references: tuple[Scalar, ...]
    previews: tuple[Scalar, ...]
    hands: tuple[ManualInput | None, ...]
    """Manual inputs of every controller; None without a manual mode."""
    free: Numbers
    """Signals of the plant without a controller."""
    numbers: tuple[tuple[Scalar, Scalar], ...]
    """Normal numbers of noise and jitter, for every sensor."""
