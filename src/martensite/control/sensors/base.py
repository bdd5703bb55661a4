"""Interface of a sensor: a true signal in, a reading out.

`step` is the analogue part of a sensor: lag and noise. The digital part (`digits`) rounds to the resolution and limits
to the range. `reading` is both. All are straight-line kernels over a namespace; differentiation ignores rounding. The
bench adds sample time, delay and lost samples (`martensite.control.loop.parts`).

Each reading takes one given standard normal number, so that runs are reproducible.
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
    """SI unit of the readings; None for the unit of the first measured signal."""
    sees: ClassVar[tuple[str, ...]] = ()
    """Names of the true signals that it measures, in the order of `step`."""

    noise: Scalar = 0.0
    resolution: Scalar = 0.0

    def limits(self) -> tuple[Scalar, Scalar] | None:
        """Return the lowest and highest reading; None for an unlimited range."""
        return None

    def valid(self, xp: Namespace, truth: Column) -> Flag:
        """Return whether the input is valid; otherwise the last reading is held."""
        return True

    def rest(self, xp: Namespace, truth: Column) -> Column:
        """Return the memory after a long time at constant inputs."""
        return ()

    @abstractmethod
    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """Return the reading before rounding, and the new memory.

        Args:
            xp: namespace.
            state: memory `dt` ago.
            truth: true signals now, constant during `dt`.
            noise: standard normal number.
            dt: time since the last reading [s]; 0 for the first.
        """

    def reading(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """Return the rounded reading within the range, and the new memory."""
        value, after = self.step(xp, state, truth, noise, dt)
        return self.digits(xp, value), after

    def digits(self, xp: Namespace, value: Scalar) -> Scalar:
        """Return a value, rounded to the resolution and limited to the range."""
        least, limits = self.resolution, self.limits()
        some = least > 0.0
        steps = xp.nearest(value / xp.where(some, least, 1.0))
        value = xp.where(some, steps * least, value)
        return value if limits is None else xp.clip(value, *limits)


class Probe:
    """A sensor with its memory and noise, read sample by sample."""

    def __init__(self, sensor: AbstractSensor, rng: np.random.Generator) -> None:
        self.sensor, self._rng = sensor, rng
        self._state: Column | None = None
        self._noise: list[float] = []

    def read(self, truth: Column, dt: float) -> float:
        """Return the reading `dt` [s] after the last one; the first reading is in the steady state."""
        if self._state is None:
            self._state, dt = self.sensor.rest(floats, truth), 0.0
        if not self._noise:
            self._noise = self._rng.standard_normal(DRAWN)[::-1].tolist()
        noise = self._noise.pop()
        value, self._state = self.sensor.reading(floats, self._state, truth, noise, dt)
        return value


def simulate_readings(sensor: AbstractSensor, truth: Numbers, interval: float, rng: np.random.Generator) -> Numbers:
    """Simulate the readings of a sensor for a record that begins in the steady state.

    Args:
        sensor: the sensor.
        truth: true signals in the order of `sees`, of shape (samples, signals).
        interval: sample time [s].
        rng: generator of the noise.

    Returns:
        The readings, of shape (samples,).

    Raises:
        InputError: the number of signals does not fit the sensor.
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
