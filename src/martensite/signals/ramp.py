"""Ramp: linear from one level to the other.

    u(t) = low + (high − low) (t − start)/(end − start)  for start ≤ t ≤ end

The signal is `low` before and `high` afterwards.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.signals.base import DRIVE, MANY, WAVEFORMS, AbstractWaveform
from martensite.signals.edges import blend_arrays, blend_levels, select_inside
from martensite.signals.levels import HIGH
from martensite.signals.moments import Segment


@WAVEFORMS.register("ramp")
class Ramp(AbstractWaveform):
    """Linear transition from `low` to `high`; it falls if `low` is above `high`."""

    low: Number = param(DRIVE, "level up to `start`", default=0.0)
    high: Number = param(DRIVE, "level from `end` on", typical=HIGH)
    start: Number = param("s", "time at which the ramp begins", low=0.0, default=0.0, typical="0.5 s")
    end: Number = param("s", "time at which the ramp ends", above=0.0, typical="5 s")

    @override
    def check(self) -> None:
        if self.end <= self.start:
            raise ParameterError(
                f"Parameter `end` of `ramp` must be above `start` = {self.start:.6g} s, "
                f"but is {self.end:.6g} s; for a jump use `step`."
            )

    @override
    def value(self, time: float) -> float:
        return blend_levels(self.low, self.high, (time - self.start) / (self.end - self.start))

    @override
    def signals(self, times: Sequence[float]) -> list[float]:
        if len(times) < MANY:
            return super().signals(times)
        import numpy as np

        shares = (np.array(times) - self.start) / (self.end - self.start)
        return blend_arrays(self.low, self.high, shares).tolist()

    @override
    def edges(self, duration: float) -> list[float]:
        return select_inside((self.start, self.end), duration)

    @override
    def segments(self, begin: float) -> Iterator[Segment]:
        if self.start > 0.0:
            yield Segment(0.0, self.low)
        yield Segment(self.start, self.low, (self.high - self.low) / (self.end - self.start))
        yield Segment(self.end, self.high)
