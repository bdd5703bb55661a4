"""Table: linear between samples, constant before the first and after the last."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from itertools import pairwise

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, param, part
from martensite.signals.base import MANY, WAVEFORMS, AbstractWaveform
from martensite.signals.edges import blend_arrays, blend_levels, select_inside
from martensite.signals.levels import SAMPLES
from martensite.signals.moments import Segment


@WAVEFORMS.register("table")
class Table(AbstractWaveform):
    """Signal given at some times; for measured signals see `martensite.signals.records`."""

    times: tuple[float, ...] = part(
        "times of the samples [s], ascending", default=(), typical=("0 s", "1 s", "4 s", "5 s")
    )
    values: tuple[float, ...] = part("samples, in the unit of the source", default=(), typical=SAMPLES)
    factor: Number = param("1", "factor of all samples", default=1.0)
    stretch: Number = param("1", "factor of all times", above=0.0, default=1.0)

    @override
    def check(self) -> None:
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
                raise ParameterError(f"Numbers of a `table` must be finite, but row {row} holds {time} and {value}.")
        for row, (before, time) in enumerate(pairwise(self.times), start=2):
            if time <= before:
                raise ParameterError(
                    f"Time must increase from row to row, but row {row} goes from {before:.15g} s to {time:.15g} s."
                )

    @override
    def value(self, time: float) -> float:
        return self.factor * self._sample(time / self.stretch)

    @override
    def signals(self, times: Sequence[float]) -> list[float]:
        if len(times) < MANY:
            return super().signals(times)
        import numpy as np

        samples, levels = np.array(self.times), np.array(self.values)
        scaled = np.array(times) / self.stretch
        place = np.clip(np.searchsorted(samples, scaled, side="right"), 1, len(samples) - 1)
        first, last = levels[place - 1], levels[place]
        share = (scaled - samples[place - 1]) / (samples[place] - samples[place - 1])
        return (self.factor * blend_arrays(first, last, share)).tolist()

    @override
    def segments(self, begin: float) -> Iterator[Segment]:
        at = max(0, bisect_right(self.times, begin / self.stretch) - 1)
        factor, stretch = self.factor, self.stretch
        if at == 0 and self.times[0] > 0.0:
            yield Segment(0.0, factor * self.values[0])
        for k in range(at, len(self.times) - 1):
            rise, time = self.values[k + 1] - self.values[k], self.times[k + 1] - self.times[k]
            yield Segment(self.times[k] * stretch, factor * self.values[k], factor * rise / (time * stretch))
        yield Segment(self.times[-1] * stretch, factor * self.values[-1])

    def _sample(self, time: float) -> float:
        right = bisect_right(self.times, time)
        if right == 0:
            return self.values[0]
        if right == len(self.times):
            return self.values[-1]
        before, after = self.times[right - 1], self.times[right]
        share = (time - before) / (after - before)
        return blend_levels(self.values[right - 1], self.values[right], share)

    @override
    def edges(self, duration: float) -> list[float]:
        v = self.values
        around = zip((v[0], *v[:-1]), v, (*v[1:], v[-1]), self.times, strict=True)
        return select_inside((t * self.stretch for a, b, c, t in around if not a == b == c), duration)
