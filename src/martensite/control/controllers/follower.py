"""A follower: the signal of a drive that the controller of another one plans.

A controller that is good for several drives, such as `mpc`, has one of them itself and names the others as those that
it `leads`. Each of these has a follower, so that every drive has one controller with its reference, its wanted signal
and its place under the supervisor.
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
    """The signal that the controller of another drive has planned for this one."""

    holds = False

    measured: str = text("reading that its reference is for, if its leader follows that", default="")
    reference: AbstractWaveform = part(
        "what that reading shall be, in its SI unit", WAVEFORMS, default=Constant(level=0.0)
    )
    low: Number = param(DRIVE, "least signal that it passes on", default=-math.inf)
    high: Number = param(DRIVE, "largest signal that it passes on; the guard by default asks for it", default=math.inf)

    def reads(self) -> tuple[str, ...]:
        """Return the name of the planned signal and of the reading that its reference is for."""
        return (PLANNED, self.measured) if self.measured else (PLANNED,)

    def reference_unit(self, readings: Mapping[str, str], signal: str) -> str:
        """SI unit of that reading; of the signal, if there is none."""
        return readings[self.measured] if self.measured else signal

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        """Return the signal that was planned in this sample."""
        return xp.clip(readings[PLANNED], self.low, self.high), ()
