"""Staircase: level k is first + k·increment, and each of `count` levels lasts `hold`.

Afterwards the last level stays. With the direction "up-down", the levels then descend (the top level is held once) and
the first level stays.
"""

from __future__ import annotations

from collections.abc import Iterator

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.signals.base import DRIVE, WAVEFORMS, AbstractWaveform
from martensite.signals.edges import find_interval, select_inside
from martensite.signals.levels import INCREMENT
from martensite.signals.moments import Segment


@WAVEFORMS.register("staircase")
class Staircase(AbstractWaveform):
    """Equal jumps at equal times, up and optionally down again."""

    first: Number = param(DRIVE, "first level", default=0.0)
    increment: Number = param(DRIVE, "jump from one level to the next", typical=INCREMENT)
    hold: Number = param("s", "time on each level", low=1e-9, high=1e9, typical="2 s")
    count: Number = param("1", "number of levels", low=1.0, high=1e6, typical=4.0)
    direction: str = option("what follows the last level", "up", "up-down", default="up")

    stepwise = True

    @override
    def check(self) -> None:
        if self.count != int(self.count):
            raise ParameterError(f"Parameter `count` of `staircase` must be a whole number, but is {self.count:.6g}.")

    @override
    def value(self, time: float) -> float:
        return self._level(self._step(time))

    @override
    def edges(self, duration: float) -> list[float]:
        jumps = min(self._last, int(duration / self.hold) + 1)
        return select_inside((self._start(k) for k in range(1, jumps + 1)), duration)

    @override
    def segments(self, begin: float) -> Iterator[Segment]:
        for step in range(self._step(begin), self._last + 1):
            yield Segment(self._start(step), self._level(step))

    def _step(self, time: float) -> int:
        return min(max(find_interval(time, time / self.hold, self._start), 0), self._last)

    def _level(self, step: int) -> float:
        top = int(self.count) - 1
        return self.first + (step if step <= top else 2 * top - step) * self.increment

    def _start(self, k: int) -> float:
        return k * self.hold

    @property
    def _last(self) -> int:
        """Return the number of jumps."""
        top = int(self.count) - 1
        return top if self.direction == "up" else 2 * top
