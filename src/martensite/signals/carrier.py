"""Carrier: a duty becomes pulses, on for k/f ≤ t < (k + D_k)/f with D_k the duty at k/f.

The duty is read at the start of every period and held, as a timer does; below 0 it counts as 0,
above 1 as 1. On is 1 and off is 0: the signal of a switch, for the drive `pwm-voltage`.

A real switch cannot make a pulse (or a gap) as short as wanted: those below `shortest` become
`shortest` or nothing, whichever is nearer.
"""

from __future__ import annotations

from typing import ClassVar

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param, part
from martensite.signals.base import WAVEFORMS, AbstractWaveform
from martensite.signals.pulses import AbstractPulses


def limit_duty(duty: float, shortest: float) -> float:
    """Return the share of a period that is on, for a duty and a `shortest` pulse as a share of the period."""
    duty = min(max(duty, 0.0), 1.0)
    if duty < shortest:
        return shortest if duty >= 0.5 * shortest else 0.0
    if 1.0 - duty < shortest:
        return 1.0 - shortest if 1.0 - duty >= 0.5 * shortest else 1.0
    return duty


@WAVEFORMS.register("carrier")
class Carrier(AbstractPulses):
    """Pulses of 0 and 1 at a constant frequency, as long as another waveform says."""

    unit: ClassVar[str | None] = "1"

    duty: AbstractWaveform = part(
        "share of the period that is on, over time", WAVEFORMS, typical={"kind": "constant", "level": 0.2}
    )
    frequency: Number = param("Hz", "frequency", above=0.0, high=1e9, typical="100 Hz")
    shortest: Number = param("s", "shortest pulse or gap that the switch can make", low=0.0, default=0.0)

    def check(self) -> None:
        """Raise `ParameterError` if no pulse fits into a period."""
        if self.shortest * self.frequency > 0.5:
            raise ParameterError(
                f"Parameter `shortest` of `carrier` must be at most half a period, "
                f"{0.5 / self.frequency:.6g} s, but is {self.shortest:.6g} s."
            )

    def share(self, k: int) -> float:
        """Return the duty at the start of period k, as the switch can make it."""
        return limit_duty(self.duty.value(self._start(k)), self.shortest * self.frequency)

    def value(self, time: float) -> float:
        """1 while on, else 0; the new one at a jump itself."""
        return 1.0 if self.is_on(time) else 0.0
