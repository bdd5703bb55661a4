"""Step or single pulse: u = high for at ≤ t < until, else low."""

from __future__ import annotations

import math
from collections.abc import Iterator

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.signals.base import DRIVE, WAVEFORMS, AbstractWaveform
from martensite.signals.edges import select_inside
from martensite.signals.levels import HIGH
from martensite.signals.moments import Segment


@WAVEFORMS.register("step")
class Step(AbstractWaveform):
    """Jump from `low` to `high`, and back at `until` if given.

    For a downward step, `low` is above `high`.
    """

    low: Number = param(DRIVE, "level before the step, and after `until`", default=0.0)
    high: Number = param(DRIVE, "level from the step on", typical=HIGH)
    at: Number = param("s", "time of the step", low=0.0, default=0.0, typical="0.5 s")
    until: Number = param("s", "time of the step back; none if left out", default=math.inf, typical="1.75 s")

    stepwise = True

    @override
    def check(self) -> None:
        if self.until <= self.at:
            raise ParameterError(
                f"Parameter `until` of `step` must be above `at` = {self.at:.6g} s, but is {self.until:.6g} s."
            )

    @override
    def value(self, time: float) -> float:
        return self.high if self.at <= time < self.until else self.low

    @override
    def edges(self, duration: float) -> list[float]:
        return select_inside((self.at, self.until), duration)

    @override
    def segments(self, begin: float) -> Iterator[Segment]:
        if self.at > 0.0:
            yield Segment(0.0, self.low)
        yield Segment(self.at, self.high)
        if math.isfinite(self.until):
            yield Segment(self.until, self.low)
