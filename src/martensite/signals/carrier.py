"""Carrier: pulses of a duty cycle, on for k/f ≤ t < (k + D_k)/f with D_k the duty cycle at k/f.

The duty cycle is read at the start of each period, limited to 0 … 1, and held. On is 1 and off is 0, for the drive
`pwm-voltage`. Pulses and gaps below `shortest` become `shortest` or zero, whichever is nearer.
"""

from __future__ import annotations

from typing import ClassVar

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, param, part
from martensite.signals.base import WAVEFORMS, AbstractWaveform
from martensite.signals.pulses import AbstractPulses


def limit_duty(duty: float, shortest: float) -> float:
    """Return the duty cycle that a switch can make; `shortest` is a fraction of the period."""
    duty = min(max(duty, 0.0), 1.0)
    if duty < shortest:
        return shortest if duty >= 0.5 * shortest else 0.0
    if 1.0 - duty < shortest:
        return 1.0 - shortest if 1.0 - duty >= 0.5 * shortest else 1.0
    return duty


@WAVEFORMS.register("carrier")
class Carrier(AbstractPulses):
    """Pulses of 0 and 1 at a constant frequency; another waveform gives the duty cycle."""

    unit: ClassVar[str | None] = "1"

    duty: AbstractWaveform = part(
        "share of the period that is on, over time", WAVEFORMS, typical={"kind": "constant", "level": 0.2}
    )
    frequency: Number = param("Hz", "frequency", above=0.0, high=1e9, typical="100 Hz")
    shortest: Number = param("s", "shortest pulse or gap that the switch can make", low=0.0, default=0.0)

    @override
    def check(self) -> None:
        if self.shortest * self.frequency > 0.5:
            raise ParameterError(
                f"Parameter `shortest` of `carrier` must be at most half a period, "
                f"{0.5 / self.frequency:.6g} s, but is {self.shortest:.6g} s."
            )

    @override
    def share(self, k: int) -> float:
        return limit_duty(self.duty.value(self._start(k)), self.shortest * self.frequency)

    @override
    def value(self, time: float) -> float:
        return 1.0 if self.is_on(time) else 0.0
