"""Measuring channels: a converter with its amplifier, whatever it converts; a lag, and the rate of an angle.

    τ dx/dt = y - x,    reading = round((c(x) + b + σ n)/q) q,  within ±range

y is the truth, c the curve of the channel, which for all but some is (1 + g) x with an error g of
the gain. b is the offset, q the least step of the converter. The lag is exact for a truth that is held over the step,
x(t + Δt) = x + (1 - exp(-Δt/τ)) (y - x).
"""

import math

from martensite.base.parameters import Number, param
from martensite.control.sensors.base import SENSORS, AbstractSensor, Column
from martensite.kernels.namespace import Namespace, Scalar

DEGREE = math.pi / 180.0


class AbstractChannel(AbstractSensor):
    """One truth with lag, gain, offset and noise; a subclass declares these in its own unit."""

    offset: Scalar
    """Reading of nothing."""
    range: Scalar
    """Largest reading, either way."""
    gain_error: Number = param("1", "error of the gain", above=-1.0, default=0.0)
    lag: Number = param("s", "time constant; 0 for none", low=0.0, default=0.0)

    def rest(self, xp: Namespace, truth: Column) -> Column:
        """Return the truth."""
        return (truth[0],)

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """Return the lagged input through the curve, with offset and noise."""
        felt = follow_lag(xp, state[0], truth[0], self.lag, dt)
        return self.curve(xp, felt) + self.offset + self.noise * noise, (felt,)

    def curve(self, xp: Namespace, felt: Scalar) -> Scalar:
        """Return the output of the channel for a lagged input."""
        return (1.0 + self.gain_error) * felt

    def limits(self) -> tuple[Scalar, Scalar]:
        """Return symmetric limits of the range."""
        return -self.range, self.range


def follow_lag(xp: Namespace, felt: Scalar, truth: Scalar, lag: Scalar, dt: Scalar) -> Scalar:
    """Return the lagged value of a truth that has been constant for `dt` [s]; the truth without a lag."""
    some = lag > 0.0
    share = 1.0 - xp.exp(-dt / xp.where(some, lag, 1.0))
    return xp.where(some, felt + share * (truth - felt), truth)


@SENSORS.register("current")
class CurrentSensor(AbstractChannel):
    """The current, with errors of gain and offset.

    I is the current through the element, for a switched source the rms current of a period. The defaults are assumed:
    ±5 A in 12 bits, and noise of two steps.
    """

    unit = "A"
    sees = ("current",)

    offset: Number = param("A", "reading of zero", default=0.0)
    noise: Number = param("A", "standard deviation of a reading", low=0.0, default=5e-3)
    resolution: Number = param("A", "least step of a reading", low=0.0, default=5.0 / 2**11)
    range: Number = param("A", "largest reading, either way", above=0.0, default=5.0)


@SENSORS.register("voltage")
class VoltageSensor(AbstractChannel):
    """The voltage, with errors of gain and offset.

    U is the voltage across the element, for a switched source the rms voltage of a period. The defaults are assumed:
    ±20 V in 12 bits, and noise of two steps.
    """

    unit = "V"
    sees = ("voltage",)

    offset: Number = param("V", "reading of zero", default=0.0)
    noise: Number = param("V", "standard deviation of a reading", low=0.0, default=20e-3)
    resolution: Number = param("V", "least step of a reading", low=0.0, default=20.0 / 2**11)
    range: Number = param("V", "largest reading, either way", above=0.0, default=20.0)


@SENSORS.register("force")
class ForceSensor(AbstractChannel):
    """The force, with errors of gain, offset and linearity.

        c(F) = (1 + g) F + 4 ν F (1 - |F|/range)

    ν is the nonlinearity: the largest deviation from the straight line through zero and full load, as a share of the
    range, reached at half of it. Creep and hysteresis of the cell are not modelled, nor is its own compliance, which a
    soft one adds to the mechanism.

    The defaults are assumed: a range of 50 N in 16 bits.
    """

    unit = "N"
    sees = ("force",)

    nonlinearity: Number = param("1", "largest deviation from a line over the range", low=-0.25, high=0.25, default=0.0)
    offset: Number = param("N", "reading of zero", default=0.0)
    noise: Number = param("N", "standard deviation of a reading", low=0.0, default=5e-3)
    resolution: Number = param("N", "least step of a reading", low=0.0, default=50.0 / 2**15)
    range: Number = param("N", "largest reading, either way", above=0.0, default=50.0)

    def curve(self, xp: Namespace, felt: Scalar) -> Scalar:
        """c(F) [N]; beyond the range it goes on straight."""
        within = xp.clip(felt, -self.range, self.range)
        bow = 4.0 * self.nonlinearity * within * (1.0 - xp.abs(within) / self.range)
        return super().curve(xp, felt) + bow


@SENSORS.register("tilt")
class TiltSensor(AbstractChannel):
    """An angle with a low-pass.

    An accelerometer feels the direction of gravity, and every jolt with it; the low-pass of time constant τ that keeps
    jolts away makes it late. What jolts leave behind is part of the noise σ: accelerations of what it sits on are not
    computed. b is an error of mounting. An angle without that lag is got from both a `tilt` and a `gyroscope`, by an
    observer.

    All defaults are assumed.
    """

    unit = "rad"
    sees = ("angle",)

    lag: Number = param("s", "time constant; 0 for none", low=0.0, default=0.05)
    offset: Number = param("rad", "reading of zero", default=0.0)
    noise: Number = param("rad", "standard deviation of a reading", low=0.0, default=0.1 * DEGREE)
    resolution: Number = param("rad", "least step of a reading", low=0.0, default=0.01 * DEGREE)
    range: Number = param("rad", "largest reading, either way", above=0.0, default=0.5 * math.pi)


@SENSORS.register("gyroscope")
class GyroscopeSensor(AbstractSensor):
    """Angular rate, from differences of an angle.

        y = (φ - φ⁻)/Δt,    τ dω/dt = y - ω,    reading = round((ω + b + σ n)/q) q,  within ±range

    y is the mean rate since the reading before, from the angles then and now, so that its integral is the way gone. Its
    bandwidth 1/(2π τ) is that of a lag. b is the bias, a constant: integrated, it makes an angle that runs away.

    The defaults are assumed: a range of ±2000 deg/s in 16 bits, 40 Hz, and noise of 0.1 deg/s.
    """

    unit = "rad/s"
    sees = ("angle",)

    bias: Number = param("rad/s", "reading at rest", default=0.0)
    lag: Number = param("s", "time constant; 0 for none", low=0.0, default=4e-3)
    noise: Number = param("rad/s", "standard deviation of a reading", low=0.0, default=0.1 * DEGREE)
    resolution: Number = param("rad/s", "least step of a reading", low=0.0, default=2000.0 * DEGREE / 2**15)
    range: Number = param("rad/s", "largest reading, either way", above=0.0, default=2000.0 * DEGREE)

    def limits(self) -> tuple[Scalar, Scalar]:
        """Return symmetric limits of the range."""
        return -self.range, self.range

    def rest(self, xp: Namespace, truth: Column) -> Column:
        """Return the angle, and no rate."""
        return truth[0], 0.0

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """Return the lagged rate with bias and noise [rad/s]; in no time it stays as it was."""
        before, felt = state
        some = dt > 0.0
        rate = xp.where(some, (truth[0] - before) / xp.where(some, dt, 1.0), felt)
        felt = follow_lag(xp, felt, rate, self.lag, dt)
        return felt + self.bias + self.noise * noise, (truth[0], felt)
