"""Table: linear between the samples of a list, held before the first and after the last."""

from __future__ import annotations

import math
from bisect import bisect_right
from itertools import pairwise

from martensite.errors import ParameterError
from martensite.parameters import part
from martensite.signals.base import WAVEFORMS, AbstractWaveform
from martensite.signals.edges import blend, inside


@WAVEFORMS.register("table")
class Table(AbstractWaveform):
    """A signal known at some times; for measured ones see `martensite.signals.records`."""

    times: tuple[float, ...] = part("times of the samples [s], ascending", default=())
    values: tuple[float, ...] = part("samples, in the unit of the source", default=())

    def check(self) -> None:
        """Two rows at least, all numbers finite, times ascending."""
        if len(self.times) != len(self.values):
            raise ParameterError(
                f"`times` and `values` of `table` must be equally long, but hold "
                f"{len(self.times)} and {len(self.values)} numbers."
            )
        if len(self.times) < 2:
            raise ParameterError(f"A `table` needs at least 2 rows, but has {len(self.times)}.")
        rows = zip(self.times, self.values, strict=True)
        for row, (time, value) in enumerate(rows, start=1):
            if not (math.isfinite(time) and math.isfinite(value)):
                raise ParameterError(
                    f"Numbers of a `table` must be finite, but row {row} holds {time} and {value}."
                )
        for row, (before, time) in enumerate(pairwise(self.times), start=2):
            if time <= before:
                raise ParameterError(
                    f"Time must increase from row to row, but row {row} goes from "
                    f"{before:.15g} s to {time:.15g} s."
                )

    def value(self, time: float) -> float:
        """Level at `time` [s]."""
        right = bisect_right(self.times, time)
        if right == 0:
            return self.values[0]
        if right == len(self.times):
            return self.values[-1]
        before, after = self.times[right - 1], self.times[right]
        share = (time - before) / (after - before)
        return blend(self.values[right - 1], self.values[right], share)

    def edges(self, duration: float) -> list[float]:
        """The samples in (0, duration) at which the signal does not just stay level [s]."""
        v = self.values
        around = zip((v[0], *v[:-1]), v, (*v[1:], v[-1]), self.times, strict=True)
        return inside((t for a, b, c, t in around if not a == b == c), duration)
