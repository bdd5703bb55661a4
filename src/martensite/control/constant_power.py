"""Constant power: in every period the duty is the demanded power over the largest one.

    D_k = P(t_k)/P_max,    P_max = U I/u

with voltage U and current I of the element, measured while the switch is closed (u = 1; under
an averaged duty u both go with √u). `every-period` takes the last measurement, so that the
power is late by one period of change in resistance. `once` takes the first one for ever, as in
the paper on a finger prototype; the power is then wrong by P_max(R)/P_max(R₀).

A loop over pulses: `simulate_loop(system, ConstantPower(...), ..., pulses=True)` with the drive
`pwm-voltage`. Its average is the drive `power-pwm`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from martensite.errors import InputError
from martensite.parameters import option, param, part
from martensite.signals.base import WAVEFORMS, AbstractDrive, AbstractWaveform


class ConstantPower(AbstractDrive):
    """Duty of a switch from a demanded power [W]; remembers the largest power [W]."""

    cites = ("finger-paper",)

    demand: AbstractWaveform = part("demanded power [W] over time", WAVEFORMS)
    measured: str = option(
        "when the largest power is measured: in `every-period`, or `once` before the run",
        "every-period",
        "once",
        default="every-period",
    )
    largest: float = param(
        "W", "largest power, if it is measured once and that was done before",
        above=0.0, default=math.inf,
    )  # fmt: skip

    def init(self) -> float:
        """The largest power [W] as far as it is known; else 0."""
        known = self.measured == "once" and math.isfinite(self.largest)
        return self.largest if known else 0.0

    def __call__(
        self, time: float, measurement: Mapping[str, float], memory: float
    ) -> tuple[float, float]:
        """Duty at `time` [s], above 1 where the demand is out of reach, and the largest power.

        Raises:
            InputError: nothing was ever measured while the switch was closed.
        """
        if (memory == 0.0 or self.measured == "every-period") and measurement["drive"] > 0.0:
            memory = measurement["voltage"] * measurement["current"] / measurement["drive"]
        if memory == 0.0:
            raise InputError(
                "`ConstantPower` has no measurement with the switch closed; "
                "give `probe` = 1 to the loop."
            )
        return self.demand.value(time) / memory, memory
