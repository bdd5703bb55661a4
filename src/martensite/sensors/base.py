"""The contract of a sensor: a true signal in, what it says of it out.

A sensor has an analogue part and a digital one. `step` is the analogue part, a straight-line
kernel over a namespace: what is felt of the truth, with its lag, and noise on top. `digits` is
the digital part, rounding to the least step, in NumPy or plain floats: it is no smooth operation
and never part of a derivative. What only rearranges readings in time, such as another sample
time, a delay or lost samples, is neither: it goes around a sensor.

Noise is given, not drawn: one standard normal number per reading, so that a run is the same for
the same numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.errors import InputError
from martensite.parameters import Parametrised
from martensite.registry import Registry
from martensite.runtimes import floats
from martensite.runtimes.namespace import Namespace, Scalar

SENSORS: Registry[AbstractSensor] = Registry("sensor", "martensite.sensors")
DRAWN = 1024
"""Random numbers that are drawn at a time."""
Column: TypeAlias = Sequence[Scalar]
Numbers: TypeAlias = NDArray[Any]


class AbstractSensor(Parametrised):
    """Interface of a sensor. Subclasses declare `noise` and `resolution` in their own unit."""

    unit: ClassVar[str | None] = "1"
    """SI unit of its readings; None if it is that of the first signal it looks at."""
    sees: ClassVar[tuple[str, ...]] = ()
    """What it looks at: names of true signals, in the order in which `step` takes them."""

    noise: float
    """Standard deviation of the noise of a reading."""
    resolution: float
    """Least step of a reading; 0 if it is not rounded."""

    def rest(self, xp: Namespace, truth: Column) -> Column:
        """What it remembers if the truth has been as it is for long."""
        return ()

    def step(
        self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar
    ) -> tuple[Scalar, Column]:
        """The reading before rounding, and what is remembered.

        Args:
            xp: namespace.
            state: what it remembered `dt` ago.
            truth: true signals now, held since then.
            noise: a standard normal number.
            dt: time since the reading before [s]; 0 for the first one.
        """
        raise NotImplementedError

    def digits(self, value: Any) -> Any:
        """A reading, or an array of them, rounded to the nearest step of the resolution."""
        if not self.resolution > 0.0:
            return value
        return np.round(np.asarray(value) / self.resolution) * self.resolution


class Probe:
    """A sensor in use: what it remembers, and its noise. Readings are made one by one."""

    def __init__(self, sensor: AbstractSensor, rng: np.random.Generator) -> None:
        self.sensor, self._rng = sensor, rng
        self._state: Column | None = None
        self._noise: list[float] = []

    def read(self, truth: Column, dt: float) -> float:
        """The reading `dt` [s] after the one before; the first is made at rest."""
        if self._state is None:
            self._state, dt = self.sensor.rest(floats, truth), 0.0
        if not self._noise:
            self._noise = self._rng.standard_normal(DRAWN)[::-1].tolist()
        noise = self._noise.pop()
        value, self._state = self.sensor.step(floats, self._state, truth, noise, dt)
        least = self.sensor.resolution
        return round(value / least) * least if least > 0.0 else value


def readings(
    sensor: AbstractSensor, truth: Numbers, interval: float, rng: np.random.Generator
) -> Numbers:
    """What a sensor says of a whole record, from rest.

    Args:
        sensor: the sensor.
        truth: true signals, shape (samples, signals), in the order of `sees`.
        interval: sample time [s].
        rng: where the noise comes from.

    Raises:
        InputError: there are not as many signals as the sensor looks at.
    """
    rows = np.atleast_2d(np.asarray(truth, dtype=float).T).T
    if rows.shape[1] != len(sensor.sees):
        raise InputError(
            f"Sensor `{sensor.registered_name}` looks at {' and '.join(sensor.sees)}, so the "
            f"truth needs {len(sensor.sees)} columns, but has {rows.shape[1]}."
        )
    noise = rng.standard_normal(len(rows)).tolist()
    given: list[list[float]] = rows.tolist()
    state = sensor.rest(floats, given[0])
    found: list[float] = []
    dt = 0.0
    for row, one in zip(given, noise, strict=True):
        value, state = sensor.step(floats, state, row, one, dt)
        found.append(value)
        dt = interval
    return np.asarray(sensor.digits(np.array(found)))
