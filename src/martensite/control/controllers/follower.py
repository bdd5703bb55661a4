"""Follower: the signal of a drive that another controller plans.

A controller of several drives, such as `mpc`, has one drive itself and names the others in `leads`. Each of these has a
follower, so that every drive has one controller with a reference, a wanted signal and a place under the supervisor.
"""

import math
from collections.abc import Mapping

from martensite.base.parameters import Number, param, part, text
from martensite.control.controllers.base import CONTROLLERS, PLANNED, AbstractController, Answer, Column, Readings
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE, WAVEFORMS, AbstractWaveform
from martensite.signals.constant import Constant


@CONTROLLERS.register("follower")
class Follower(AbstractController):
    """The signal that the controller of another drive has planned."""

    holds = False

    measured: str = text("reading that follows the reference, if its leader controls it", default="")
    reference: AbstractWaveform = part(
        "reference of that reading, in its SI unit", WAVEFORMS, default=Constant(level=0.0)
    )
    low: Number = param(DRIVE, "lower limit of the signal", default=-math.inf)
    high: Number = param(DRIVE, "upper limit of the signal, which the default guard needs", default=math.inf)

    def reads(self) -> tuple[str, ...]:
        return (PLANNED, self.measured) if self.measured else (PLANNED,)

    def reference_unit(self, readings: Mapping[str, str], signal: str) -> str:
        return readings[self.measured] if self.measured else signal

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        return xp.clip(readings[PLANNED], self.low, self.high), ()
