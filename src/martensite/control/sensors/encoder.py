"""Incremental encoder: it counts the edges of two tracks that are a quarter of a line apart.

    q = s/(4 N),    reading = round((y - y_0)/q) q

N lines over the span s give 4 N counts, because every line has an edge up and one down on each of the two tracks. A
rotary one has N lines per turn, s = 2π, and reads an angle; a linear one has one line per pitch, N = 1 and s the pitch,
and reads a length. It knows no absolute place: either it was taken to a reference mark, y_0 = 0, or it counts from
where it was switched on. It has no noise, and no count is lost however fast it moves.

Unrolled angles are counted on beyond a turn. The defaults are assumed.
"""

from __future__ import annotations

import math

from martensite.base.parameters import option, param
from martensite.control.sensors.base import SENSORS, AbstractSensor, Column
from martensite.kernels.namespace import Namespace, Scalar


@SENSORS.register("encoder")
class EncoderSensor(AbstractSensor):
    """Counts of a quadrature encoder, as an angle or a length."""

    unit = None
    sees = ("angle",)

    motion: str = option("what it reads: an angle, or a length", "rotary", "linear", default="rotary")
    zero: str = option(
        "where it reads 0: at its reference mark, or where it is switched on", "mark", "start", default="mark"
    )
    lines: Scalar = param("1", "lines per turn of a rotary one", above=0.0, default=1024.0)
    pitch: Scalar = param("m", "length of a line of a linear one", above=0.0, default=40e-6)

    @property
    def resolution(self) -> Scalar:  # type: ignore[override]
        """A count [rad or m]."""
        return 0.5 * math.pi / self.lines if self.motion == "rotary" else 0.25 * self.pitch

    def rest(self, xp: Namespace, truth: Column) -> Column:
        """Where it is switched on."""
        return truth[:1] if self.zero == "start" else ()

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """The way from its zero, not counted yet."""
        return (truth[0] - state[0] if self.zero == "start" else truth[0]), state
