"""Latched ON/OFF control: on from a threshold until an oscillation has died down, then off.

    on   once y > threshold
    off  once on, and A < share · largest A since then; it stays off

y and the oscillation are outputs of the system by name, such as `rotor_speed` and `displacement`
of a motor on a beam. A is half the distance of the extremes in a window, taken anew in one window
after the other; windows must be longer than a period of the oscillation.

`replayed` says what a controller would have done along a record. Up to its first switching a run
does not depend on the answer, so a run under it is right up to the second one, and so on: with
few switchings, repeated runs close the loop without a controller in the march.

Source: the ON/OFF controller of Kossoski (2018), section 5.2.1, which says "when the vibration
amplitudes of the system decrease" and leaves the measure of that open.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from martensite.errors import ParameterError, suggestion
from martensite.parameters import param, part
from martensite.signals.base import DRIVE, AbstractDrive

HAIR = 1e-9
"""Difference of times that is rounding [s]."""


class Latch(NamedTuple):
    """What a latched controller remembers."""

    on: bool
    """True from the threshold on."""
    off: bool
    """True from the end on."""
    start: float
    """Beginning of the window [s]."""
    lowest: float
    highest: float
    """Extremes in the window so far."""
    peak: float
    """Largest amplitude since it was switched on."""


class LatchedOnOff(AbstractDrive):
    """A switch that acts once: from a threshold until an amplitude has fallen."""

    cites = ("kossoski2018",)

    measured: str = part("name of the output that switches it on")
    threshold: float = param("1", "value above which it is on, in the SI unit of that output")
    oscillation: str = part("name of the output whose amplitude switches it off")
    share: float = param(
        "1", "share of the largest amplitude below which it is off", low=0.0, high=1.0, default=0.3
    )
    window: float = param("s", "length of the window of an amplitude", above=0.0, default=0.25)
    high: float = param(DRIVE, "signal while it is on")
    low: float = param(DRIVE, "signal while it is off", default=0.0)

    def init(self) -> Latch:
        """Off, and nothing measured."""
        return Latch(False, False, 0.0, float("inf"), float("-inf"), 0.0)

    def __call__(
        self, time: float, measurement: Mapping[str, float], memory: Latch
    ) -> tuple[float, Latch]:
        """Signal at `time` [s], in the unit of the source, and the new memory.

        Raises:
            ParameterError: the system has no output of a name given.
        """
        for name in (self.measured, self.oscillation):
            if name not in measurement:
                raise ParameterError(
                    f"`LatchedOnOff` cannot measure `{name}`: the system has no such output. "
                    f"{suggestion(name, measurement)}"
                )
        memory = self._seen(time, measurement[self.oscillation], memory)
        memory = memory._replace(on=memory.on or measurement[self.measured] > self.threshold)
        return (self.high if memory.on and not memory.off else self.low), memory

    def _seen(self, time: float, value: float, memory: Latch) -> Latch:
        """The memory with one more value; at the end of a window its amplitude is judged."""
        low, high = min(value, memory.lowest), max(value, memory.highest)
        if time < memory.start + self.window - HAIR:
            return memory._replace(lowest=low, highest=high)
        amplitude = 0.5 * (high - low)
        peak = max(memory.peak, amplitude) if memory.on else 0.0
        off = memory.off or amplitude < self.share * peak
        return Latch(memory.on, off, time, value, value, peak)


def replayed(
    drive: AbstractDrive, times: Sequence[float], columns: Mapping[str, Sequence[float]]
) -> list[float]:
    """Signal that a controller gives at every sample of a record.

    Args:
        drive: the controller.
        times: sample times [s].
        columns: outputs by name, one value per sample, in SI.
    """
    memory, signals = drive.init(), list[float]()
    for k, time in enumerate(times):
        row = {name: column[k] for name, column in columns.items()}
        signal, memory = drive(time, row, memory)
        signals.append(signal)
    return signals
