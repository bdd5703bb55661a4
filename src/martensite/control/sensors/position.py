"""Sensors of a position: linear sensor, encoder, and an exact sensor of any output."""

import math

from martensite.base.parameters import Number, option, param
from martensite.control.sensors.base import SENSORS, AbstractSensor, Column
from martensite.kernels.namespace import Namespace, Scalar


@SENSORS.register("position")
class PositionSensor(AbstractSensor):
    """A position sensor without lag.

        p⁺ = max(y - w/2, min(y + w/2, p)),    reading = round((p + b + v t + σ n)/q) q

    p is the position of the slider, y the position of the moving part, and w the backlash between them: after a
    reversal the slider stays until the play is used up (Krasnosel'skii and Pokrovskii 1989). It starts in the middle of
    the play. b is the offset of the zero, which drifts at the constant rate v.

    The defaults belong to a magnetic encoder of 12 bits over poles of 2 mm, q = 2 mm/4096, without play, offset and
    drift; the noise is assumed.
    """

    cites = ("copaci2019", "krasnoselskii1989")
    unit = "m"
    sees = ("position",)

    noise: Number = param("m", "standard deviation of a reading", low=0.0, default=0.5e-6)
    resolution: Number = param("m", "least step of a reading", low=0.0, default=2e-3 / 4096)
    backlash: Number = param("m", "play between sensor and what moves", low=0.0, default=0.0)
    offset: Number = param("m", "reading of zero at the start", default=0.0)
    drift: Number = param("m/s", "change of the offset with time", default=0.0)

    def rest(self, xp: Namespace, truth: Column) -> Column:
        return truth[0], 0.0

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        half, time = 0.5 * self.backlash, state[1] + dt
        place = xp.maximum(truth[0] - half, xp.minimum(truth[0] + half, state[0]))
        value = place + (self.offset + self.drift * time)
        return value + self.noise * noise, (place, time)


@SENSORS.register("encoder")
class EncoderSensor(AbstractSensor):
    """Counts of a quadrature encoder, as an angle or a length.

        q = s/(4 N),    reading = round((y - y_0)/q) q

    N lines over the span s give 4 N counts: each line has a rising and a falling edge on each of two tracks. A rotary
    encoder has N lines per turn, s = 2π, and reads an angle that continues beyond one turn. A linear encoder has one
    line per pitch, N = 1 and s the pitch, and reads a length. It is incremental: y_0 is a reference mark, y_0 = 0, or
    the position at switch-on. It has no noise and loses no count at any speed.

    The defaults are assumed.
    """

    unit = None
    sees = ("angle",)

    motion: str = option("what it reads: an angle, or a length", "rotary", "linear", default="rotary")
    zero: str = option("where it reads 0: at its mark, or where it is switched on", "mark", "start", default="mark")
    lines: Number = param("1", "lines per turn of a rotary one", above=0.0, default=1024.0)
    pitch: Number = param("m", "length of a line of a linear one", above=0.0, default=40e-6)

    @property
    def resolution(self) -> Scalar:  # type: ignore[override]
        return 0.5 * math.pi / self.lines if self.motion == "rotary" else 0.25 * self.pitch

    def rest(self, xp: Namespace, truth: Column) -> Column:
        return truth[:1] if self.zero == "start" else ()

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        return (truth[0] - state[0] if self.zero == "start" else truth[0]), state


@SENSORS.register("ideal")
class IdealSensor(AbstractSensor):
    """Exact reading of any output, in the unit of the output.

    Sample time and delay of the bench apply, so that their effect alone can be seen.
    """

    unit = None
    sees = ("position",)

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        return truth[0], ()
