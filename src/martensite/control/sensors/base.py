"""The contract of a sensor: a true signal in, what it says of it out.

A sensor has an analogue part and a digital one. `step` is the analogue part: what is felt of the truth, with its lag,
and noise on top. The digital part, the same for all, rounds to the nearest step of the resolution and stops at the ends
of the range. `reading` is both. All are straight-line kernels over a namespace; to differentiation rounding is not
there. What only rearranges readings in time, such as another sample time, a delay or lost samples, goes around a sensor
(`martensite.control.loop.parts`).

Noise is given, not drawn: one standard normal number per reading, so that a run is the same for the same numbers.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

from martensite.base.errors import InputError
from martensite.base.parameters import Parametrised
from martensite.base.registry import Registry
from martensite.kernels import floats
from martensite.kernels.namespace import Flag, Namespace, Scalar

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

SENSORS: Registry[AbstractSensor] = Registry("sensor", "martensite.control.sensors", typical="ideal")
DRAWN = 1024
"""Random numbers that are drawn at a time."""
Column: TypeAlias = Sequence[Scalar]
Numbers: TypeAlias = "NDArray[Any]"


class AbstractSensor(Parametrised):
    """Interface of a sensor. Subclasses declare `noise` and `resolution` in their own unit."""

    unit: ClassVar[str | None] = "1"
    """SI unit of its readings; None if it is that of the first signal it looks at."""
    sees: ClassVar[tuple[str, ...]] = ()
    """Names of the true signals that it measures, in the order in which `step` takes them."""

    noise: Scalar = 0.0
    """Standard deviation of the noise of a reading."""
    resolution: Scalar = 0.0
    """Least step of a reading; 0 if it is not rounded."""

    def limits(self) -> tuple[Scalar, Scalar] | None:
        """Return the lowest and highest reading; None if it says anything."""
        return None

    def valid(self, xp: Namespace, truth: Column) -> Flag:
        """Return whether there is a valid input; without a valid input, the last reading is held."""
        return True

    def rest(self, xp: Namespace, truth: Column) -> Column:
        """Return the memory after a long time at constant inputs."""
        return ()

    @abstractmethod
    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """Return the reading before rounding, and the new memory.

        Args:
            xp: namespace.
            state: what it remembered `dt` ago.
            truth: true signals now, held since then.
            noise: a standard normal number.
            dt: time since the reading before [s]; 0 for the first one.
        """

    def reading(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """Return the reading and the memory: `step`, rounded and within the range."""
        value, after = self.step(xp, state, truth, noise, dt)
        return self.digits(xp, value), after

    def digits(self, xp: Namespace, value: Scalar) -> Scalar:
        """Return the nearest step of the resolution, if there is one, within the range."""
        least, limits = self.resolution, self.limits()
        some = least > 0.0
        steps = xp.nearest(value / xp.where(some, least, 1.0))
        value = xp.where(some, steps * least, value)
        return value if limits is None else xp.clip(value, *limits)


class Probe:
    """A sensor in use: what it remembers, and its noise. Readings are made one by one."""

    def __init__(self, sensor: AbstractSensor, rng: np.random.Generator) -> None:
        self.sensor, self._rng = sensor, rng
        self._state: Column | None = None
        self._noise: list[float] = []

    def read(self, truth: Column, dt: float) -> float:
        """Return the reading `dt` [s] after the one before; the first is made at rest."""
        if self._state is None:
            self._state, dt = self.sensor.rest(floats, truth), 0.0
        if not self._noise:
            self._noise = self._rng.standard_normal(DRAWN)[::-1].tolist()
        noise = self._noise.pop()
        value, self._state = self.sensor.reading(floats, self._state, truth, noise, dt)
        return value


def simulate_readings(sensor: AbstractSensor, truth: Numbers, interval: float, rng: np.random.Generator) -> Numbers:
    """Simulate the readings of a sensor for a whole record, from rest.

    The truth, of shape (samples, signals), is in the order of `sees`, at an interval [s]; noise is drawn in portions of
    `DRAWN` numbers.

    Raises:
        InputError: there are not as many signals as the sensor looks at.
    """
    import numpy as np

    rows = np.atleast_2d(np.asarray(truth, dtype=float).T).T
    if rows.shape[1] != len(sensor.sees):
        raise InputError(
            f"Sensor `{sensor.registered_name}` looks at {' and '.join(sensor.sees)}, so the "
            f"truth needs {len(sensor.sees)} columns, but has {rows.shape[1]}."
        )
    probe = Probe(sensor, rng)
    return np.array([probe.read(row, interval) for row in rows.tolist()])
