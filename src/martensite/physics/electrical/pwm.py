"""Switched voltage, averaged: I = √D · U/(R + R_s), D the share of the time that is on.

The drive signal is the duty D, limited to [0, 1]. While the switch is closed the element takes
the power I_on² R, so the mean over a period is

    P = D I_on² R,    I_on = U/(R + R_s),

and the current that heats as much is I_on √D. A voltage D U would heat with D² instead: at a duty of 0.3 less than a
third of the power is left. Current, voltage and power of a run are therefore rms current, rms voltage and mean power.

At a duty of 0 or 1 this is the switch itself: the waveform `carrier` drives it pulse by pulse.
"""

from __future__ import annotations

from typing import ClassVar

from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.electrical.base import SOURCES, AbstractSwitch, SignalRange


@SOURCES.register("pwm-voltage")
class PwmVoltage(AbstractSwitch):
    """A constant voltage behind a switch; the drive is the share of the time that is on."""

    unit: ClassVar[str] = "1"

    def current(self, xp: Namespace, drive: Scalar, resistance: Scalar) -> Scalar:
        """Rms current [A] for a duty."""
        return xp.sqrt(xp.clip(drive, 0.0, 1.0)) * self.closed_current(xp, resistance)

    def reach(self, resistance: float) -> SignalRange:
        """A switch is closed all the time at most."""
        return SignalRange(0.0, 1.0)
