"""Measuring channels of one signal with gain, offset, lag and range, and a gyroscope.

    τ dx/dt = y - x,    reading = round((c(x) + b + σ n)/q) q,  within ±range

y is the true signal, c the curve of the channel, (1 + g) x with a gain error g unless a sensor has another one. b is
the offset, q the resolution of the converter. The lag is exact for a true signal that is constant over the step,
x(t + Δt) = x + (1 - exp(-Δt/τ)) (y - x).
"""

import math

from martensite.base.parameters import Number, param
from martensite.control.sensors.base import SENSORS, AbstractSensor, Column
from martensite.kernels.namespace import Namespace, Scalar

DEGREE = math.pi / 180.0


class AbstractChannel(AbstractSensor):
    """Interface of a channel of one signal; a subclass declares offset, noise, resolution and range in its unit."""

    offset: Scalar
    """Reading of a signal of zero."""
    range: Scalar
    """Largest size of a reading."""
    gain_error: Number = param("1", "error of the gain", above=-1.0, default=0.0)
    lag: Number = param("s", "time constant; 0 for none", low=0.0, default=0.0)

    def rest(self, xp: Namespace, truth: Column) -> Column:
        return (truth[0],)

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        felt = follow_lag(xp, state[0], truth[0], self.lag, dt)
        return self.curve(xp, felt) + self.offset + self.noise * noise, (felt,)

    def curve(self, xp: Namespace, felt: Scalar) -> Scalar:
        """Return the output of the channel for a lagged input."""
        return (1.0 + self.gain_error) * felt

    def limits(self) -> tuple[Scalar, Scalar]:
        return -self.range, self.range


def follow_lag(xp: Namespace, felt: Scalar, truth: Scalar, lag: Scalar, dt: Scalar) -> Scalar:
    """Return the lagged value after a true signal has been constant for `dt` [s]; the true signal without a lag."""
    some = lag > 0.0
    gain = 1.0 - xp.exp(-dt / xp.where(some, lag, 1.0))
    return xp.where(some, felt + gain * (truth - felt), truth)


@SENSORS.register("current")
class CurrentSensor(AbstractChannel):
    """Current sensor with errors of gain and offset.

    It measures the current through the element, for a switched source the rms value of a period. The defaults are
    assumed: ±5 A in 12 bits, and noise of two steps.
    """

    unit = "A"
    sees = ("current",)

    offset: Number = param("A", "reading of zero", default=0.0)
    noise: Number = param("A", "standard deviation of a reading", low=0.0, default=5e-3)
    resolution: Number = param("A", "least step of a reading", low=0.0, default=5.0 / 2**11)
    range: Number = param("A", "largest size of a reading", above=0.0, default=5.0)


@SENSORS.register("voltage")
class VoltageSensor(AbstractChannel):
    """Voltage sensor with errors of gain and offset.

    It measures the voltage across the element, for a switched source the rms value of a period. The defaults are
    assumed: ±20 V in 12 bits, and noise of two steps.
    """

    unit = "V"
    sees = ("voltage",)

    offset: Number = param("V", "reading of zero", default=0.0)
    noise: Number = param("V", "standard deviation of a reading", low=0.0, default=20e-3)
    resolution: Number = param("V", "least step of a reading", low=0.0, default=20.0 / 2**11)
    range: Number = param("V", "largest size of a reading", above=0.0, default=20.0)


@SENSORS.register("force")
class ForceSensor(AbstractChannel):
    """Force sensor with errors of gain, offset and linearity.

        c(F) = (1 + g) F + 4 ν F (1 - |F|/range)

    ν is the nonlinearity: the largest deviation from the line through zero and full load as a fraction of the range,
    reached at half the range. Creep, hysteresis and compliance of the load cell are not modelled.

    The defaults are assumed: a range of 50 N in 16 bits.
    """

    unit = "N"
    sees = ("force",)

    nonlinearity: Number = param("1", "largest deviation from a line over the range", low=-0.25, high=0.25, default=0.0)
    offset: Number = param("N", "reading of zero", default=0.0)
    noise: Number = param("N", "standard deviation of a reading", low=0.0, default=5e-3)
    resolution: Number = param("N", "least step of a reading", low=0.0, default=50.0 / 2**15)
    range: Number = param("N", "largest size of a reading", above=0.0, default=50.0)

    def curve(self, xp: Namespace, felt: Scalar) -> Scalar:
        within = xp.clip(felt, -self.range, self.range)
        bow = 4.0 * self.nonlinearity * within * (1.0 - xp.abs(within) / self.range)
        return super().curve(xp, felt) + bow


@SENSORS.register("tilt")
class TiltSensor(AbstractChannel):
    """Angle sensor with a low-pass, such as an accelerometer.

    The low-pass with time constant τ reduces the effect of accelerations and delays the reading. The remaining effect
    is part of the noise σ: accelerations of the mount are not computed. b is an error of mounting. An observer can
    combine a `tilt` and a `gyroscope` to an angle without lag.

    All defaults are assumed.
    """

    unit = "rad"
    sees = ("angle",)

    lag: Number = param("s", "time constant; 0 for none", low=0.0, default=0.05)
    offset: Number = param("rad", "reading of zero", default=0.0)
    noise: Number = param("rad", "standard deviation of a reading", low=0.0, default=0.1 * DEGREE)
    resolution: Number = param("rad", "least step of a reading", low=0.0, default=0.01 * DEGREE)
    range: Number = param("rad", "largest size of a reading", above=0.0, default=0.5 * math.pi)


@SENSORS.register("gyroscope")
class GyroscopeSensor(AbstractSensor):
    """Angular rate from differences of an angle.

        y = (φ - φ⁻)/Δt,    τ dω/dt = y - ω,    reading = round((ω + b + σ n)/q) q,  within ±range

    y is the mean rate since the last reading, so that its integral is the change of the angle. The bandwidth is 1/(2π
    τ). b is a constant bias: its integral drifts.

    The defaults are assumed: a range of ±2000 deg/s in 16 bits, 40 Hz, and noise of 0.1 deg/s.
    """

    unit = "rad/s"
    sees = ("angle",)

    bias: Number = param("rad/s", "reading at rest", default=0.0)
    lag: Number = param("s", "time constant; 0 for none", low=0.0, default=4e-3)
    noise: Number = param("rad/s", "standard deviation of a reading", low=0.0, default=0.1 * DEGREE)
    resolution: Number = param("rad/s", "least step of a reading", low=0.0, default=2000.0 * DEGREE / 2**15)
    range: Number = param("rad/s", "largest size of a reading", above=0.0, default=2000.0 * DEGREE)

    def limits(self) -> tuple[Scalar, Scalar]:
        return -self.range, self.range

    def rest(self, xp: Namespace, truth: Column) -> Column:
        return truth[0], 0.0

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        before, felt = state
        some = dt > 0.0
        rate = xp.where(some, (truth[0] - before) / xp.where(some, dt, 1.0), felt)
        felt = follow_lag(xp, felt, rate, self.lag, dt)
        return felt + self.bias + self.noise * noise, (truth[0], felt)
