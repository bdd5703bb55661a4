"""Moments of a signal in an interval: mean, mean square and range, in closed form.

A signal is piecewise parabolic plus tones that are present at all times,

    u(t) = level + slope τ + bend τ² + Σ A_k cos(ω_k t + φ_k),     τ = t - start of the segment

About the middle m of an interval of half width r the parabola is d₀ + d₁ x + d₂ x², and

    ⟨p⟩  = d₀ + d₂ r²/3        ⟨p²⟩ = d₀² + (d₁² + 2 d₀ d₂) r²/3 + d₂² r⁴/5
    ⟨c⟩  = A cos θ sinc ωr     θ = ω m + φ
    ⟨c_j c_k⟩ = ½ A_j A_k [cos(θ_j - θ_k) sinc(ω_j - ω_k)r + cos(θ_j + θ_k) sinc(ω_j + ω_k)r]
    ⟨p c⟩ = A [cos θ (d₀ S₀ + d₂ S₂) - sin θ d₁ S₁],      S_n = mean of xⁿ cos ωx or xⁿ sin ωx
    3 ⟨x p⟩ = d₁ r²        3 ⟨x p²⟩ = 2 d₁ (d₀ r² + 3 d₂ r⁴/5)        ⟨x c⟩ = -A sin θ S₁

so a drive is integrated, not sampled, for any step length. No formula subtracts large numbers: an interval of a
microsecond is as exact after a day as at the start.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

FITTED = 1e-9
"""Relative error of fitted parabolas."""
FINEST = 1e-7
"""Shortest fitted parabola, as a fraction of the interval."""
LOOKED_AT = tuple((k * 0.6180339887498949) % 1.0 for k in range(1, 14))
"""Irregular fractions of an interval at which a parabola is compared with the signal."""
MANY = 32
"""Number of intervals from which arrays are faster."""
RESOLVED = 0.5
"""Largest half interval, in radians of a tone, that resolves the tone."""
SERIES = 0.25
"""Argument below which 0/0 functions use their series."""


class Segment(NamedTuple):
    """Parabolic piece of a signal, up to the start of the next piece."""

    start: float
    """[s]"""
    level: float
    """Value at the start."""
    slope: float = 0.0
    """[1/s]"""
    bend: float = 0.0
    """Half of the second derivative [1/s²]."""

    def value(self, time: float) -> float:
        """Return the parabola at `time` [s]."""
        along = time - self.start
        return self.level + (self.slope + self.bend * along) * along


class Tone(NamedTuple):
    """A cos(ω t + φ), at all times."""

    amplitude: float
    rate: float
    """ω [rad/s], above 0."""
    phase: float = 0.0
    """φ [rad]"""

    def value(self, time: float) -> float:
        """Return the tone at `time` [s]."""
        return self.amplitude * math.cos(self.rate * time + self.phase)


class Moments(NamedTuple):
    """Moments of a signal in an interval."""

    mean: float
    square: float
    """Mean square."""
    low: float
    high: float
    """Upper bound."""
    lapse: float = 0.0
    """Largest lead of the signal over a straight line: [s] at its largest absolute value. It is 0 for a signal without
    jumps, bends and tones in the interval.
    """
    slope: float = 0.0
    """Slope of the best straight line [1/s]."""
    square_slope: float = 0.0
    """Slope of the best straight line through the square."""

    @classmethod
    def constant(cls, level: float) -> Moments:
        """Return the moments of a constant level."""
        return cls(level, level * level, level, level)


class SignalShape(NamedTuple):
    """Segments and tones of a signal."""

    segments: Sequence[Segment]
    """Ascending; the last segment never ends."""
    tones: Sequence[Tone] = ()

    def value(self, time: float) -> float:
        """Return the signal at `time` [s]; right-continuous."""
        at = max(0, bisect_right(self.segments, time, key=_get_start) - 1)
        return self.segments[at].value(time) + math.fsum(tone.value(time) for tone in self.tones)

    def moments(self, begin: float, end: float) -> Moments:
        """Return the moments over [begin, end] [s]."""
        at = max(0, bisect_right(self.segments, begin, key=_get_start) - 1)
        swings = [_Swing(tone, begin, end) for tone in self.tones]
        total, left = _Sum(begin, end, swings), begin
        for segment, after in zip(self.segments[at:], [*self.segments[at + 1 :], None], strict=True):
            right = end if after is None else min(end, after.start)
            total.add(segment, left, right)
            left = right
            if not right < end:
                break
        return total.moments()

    def many(self, begins: Sequence[float], ends: Sequence[float]) -> list[Moments]:
        """Return the moments over many intervals, to the same bits; intervals within a segment in arrays."""
        if len(begins) < MANY or self.tones:
            return [self.moments(a, b) for a, b in zip(begins, ends, strict=True)]
        import numpy as np

        table, first, last = np.array(self.segments), np.asarray(begins), np.asarray(ends)
        starts = table[:, 0]
        at = np.maximum(np.searchsorted(starts, first, side="right") - 1, 0)
        following = np.append(starts, np.inf)[at + 1]
        start, level, slope, bend = table[at].T
        length = last - first
        half, per = 0.5 * length, 12.0 / (length * length)
        along = first + half - start
        d0, d1 = level + (slope + bend * along) * along, slope + 2.0 * bend * along
        two = half * half
        third, fifth, curve, reach = two / 3.0, two * two / 5.0, bend * two, np.abs(d1) * half
        columns = (
            d0 + bend * third,
            d0 * d0 + (d1 * d1 + 2.0 * d0 * bend) * third + bend * bend * fifth,
            d0 - reach + np.minimum(curve, 0.0),
            d0 + reach + np.maximum(curve, 0.0),
            0.0 * d0,
            per * (d1 * third),
            per * (2.0 * d1 * (d0 * third + bend * fifth)),
        )
        rows = list(map(Moments._make, zip(*(c.tolist() for c in columns), strict=True)))
        for k in np.flatnonzero(following < last).tolist():
            rows[k] = self.moments(begins[k], ends[k])
        return rows


class _Sum:
    """Moments of a signal, accumulated over segments."""

    def __init__(self, begin: float, end: float, swings: Sequence[_Swing]) -> None:
        self.begin, self.length, self.swings = begin, end - begin, swings
        self.middle = 0.5 * (begin + end)
        self.mean = self.square = self.cross = 0.0
        self.lean = self.square_lean = 0.0
        """First moments of u and u² about the middle of the interval, over its length."""
        self.low, self.high = math.inf, -math.inf
        self.marks: list[tuple[float, float, float]] = []

    def add(self, segment: Segment, left: float, right: float) -> None:
        half, aside = 0.5 * (right - left), 0.5 * (left + right) - self.middle
        d0, d1, d2 = _center_parabola(segment, left + half)
        share, two = 2.0 * half / self.length, half * half
        third, fifth = two / 3.0, two * two / 5.0
        mean, square = d0 + d2 * third, d0 * d0 + (d1 * d1 + 2.0 * d0 * d2) * third
        square += d2 * d2 * fifth
        self.mean += share * mean
        self.square += share * square
        self.lean += share * (aside * mean + d1 * third)
        self.square_lean += share * (aside * square + 2.0 * d1 * (d0 * third + d2 * fifth))
        self.cross += share * sum(_average_product(s.tone, left, right, d0, d1, d2) for s in self.swings)
        reach, curve = abs(d1) * half, d2 * two
        self.low = min(self.low, d0 - reach + min(curve, 0.0))
        self.high = max(self.high, d0 + reach + max(curve, 0.0))
        self.marks.append((right - self.begin, self.mean, self.square))

    def moments(self) -> Moments:
        swings, per = self.swings, 12.0 / (self.length * self.length)
        low, high = self.low + sum(s.low for s in swings), self.high + sum(s.high for s in swings)
        mean, slope, second = self.mean, per * self.lean, per * self.square_lean
        lapse = self._lapse(max(abs(low), abs(high)), slope, second)
        for swing in swings:
            mean, slope = mean + swing.mean, slope + per * swing.lean
        if swings:  # slope of the square as if segments and tones were straight
            second += 2.0 * (mean * slope - self.mean * per * self.lean)
        square = self.square + 2.0 * self.cross + _average_beats(swings)
        return Moments(mean, square, low, high, lapse, slope, second)

    def _lapse(self, size: float, slope: float, second: float) -> float:
        """Return the deviation of the integrals of u and u² from straight lines, over their size."""
        if not size > 0.0:
            return 0.0
        lapse = sum(swing.lapse for swing in self.swings) / size
        if len(self.marks) == 1:
            return lapse
        length = self.length
        first = squares = 0.0
        for time, mean, square in self.marks:
            bow = 0.5 * time * (time - length)
            first = max(first, abs(length * mean - time * self.mean - slope * bow))
            squares = max(squares, abs(length * square - time * self.square - second * bow))
        return lapse + max(first / size, squares / (size * size))


class _Swing:
    def __init__(self, tone: Tone, begin: float, end: float) -> None:
        self.tone = tone
        half, middle = 0.5 * (end - begin), 0.5 * (begin + end)
        self.angle = tone.rate * middle + tone.phase
        self.reach = tone.rate * half
        size = abs(tone.amplitude)
        at, steep = tone.amplitude * math.cos(self.angle), size * abs(math.sin(self.angle))
        self.mean = at * compute_sinc(self.reach)
        self.lean = -tone.amplitude * math.sin(self.angle) * half * compute_leaning_mean(self.reach)
        spread = steep * self.reach + 0.5 * size * self.reach * self.reach
        self.low, self.high = max(-size, at - spread), min(size, at + spread)
        self.lapse = size / tone.rate if self.reach > RESOLVED else 0.0


def compute_sinc(x: float) -> float:
    """Return sin x / x."""
    if abs(x) < SERIES:
        z = x * x
        return 1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0)))
    return math.sin(x) / x


def compute_leaning_mean(x: float) -> float:
    """Return (sin x / x - cos x)/x, the mean of s sin xs over s between -1 and 1."""
    if abs(x) < SERIES:
        z = x * x
        return x * (1.0 / 3.0 - z * (1.0 / 30.0 - z * (1.0 / 840.0 - z * (1.0 / 45360.0))))
    return (math.sin(x) / x - math.cos(x)) / x


def _center_parabola(segment: Segment, middle: float) -> tuple[float, float, float]:
    along = middle - segment.start
    return (
        segment.level + (segment.slope + segment.bend * along) * along,
        segment.slope + 2.0 * segment.bend * along,
        segment.bend,
    )


def _average_product(tone: Tone, begin: float, end: float, d0: float, d1: float, d2: float) -> float:
    half, middle = 0.5 * (end - begin), 0.5 * (begin + end)
    angle, x = tone.rate * middle + tone.phase, tone.rate * half
    s0, s1 = compute_sinc(x), half * compute_leaning_mean(x)
    if abs(x) < SERIES:
        z = x * x
        s2 = half * half * (1.0 / 3.0 - z / 10.0 * (1.0 - 5.0 * z / 84.0 * (1.0 - 7.0 * z / 270.0)))
    else:
        s2 = half * half * (s0 - 2.0 * (s0 - math.cos(x)) / (x * x))
    return tone.amplitude * (math.cos(angle) * (d0 * s0 + d2 * s2) - math.sin(angle) * d1 * s1)


def _average_beats(swings: Sequence[_Swing]) -> float:
    """Return the mean square of the sum of tones."""
    total = 0.0
    for j, a in enumerate(swings):
        for k, b in enumerate(swings[: j + 1]):
            part = math.cos(a.angle - b.angle) * compute_sinc(a.reach - b.reach)
            part += math.cos(a.angle + b.angle) * compute_sinc(a.reach + b.reach)
            total += (0.5 if k == j else 1.0) * a.tone.amplitude * b.tone.amplitude * part
    return total


def _get_start(segment: Segment) -> float:
    return segment.start


def add_segments(terms: Sequence[tuple[float, Iterator[Segment]]]) -> Iterator[Segment]:
    """Yield the segments of a weighted sum of signals."""
    here = [next(segments) for _, segments in terms]
    ahead = [next(segments, None) for _, segments in terms]
    start = max(segment.start for segment in here)
    while True:
        level = slope = bend = 0.0
        for (factor, _), segment in zip(terms, here, strict=True):
            d0, d1, d2 = _center_parabola(segment, start)
            level, slope, bend = level + factor * d0, slope + factor * d1, bend + factor * d2
        yield Segment(start, level, slope, bend)
        starts = [segment.start for segment in ahead if segment is not None]
        if not starts:
            return
        start = min(starts)
        for k, segment in enumerate(ahead):
            if segment is not None and segment.start == start:
                here[k], ahead[k] = segment, next(terms[k][1], None)


def fit_parabolas(value: Callable[[float], float], first: float, last: float) -> Iterator[Segment]:
    """Yield parabolas through a signal that is smooth in [first, last), ascending."""
    stack = [(first, last)]
    while stack:
        begin, end = stack.pop()
        length = end - begin
        late = 1.0 - 1e-9  # the signal may jump at its end
        levels = value(begin), value(begin + 0.5 * length), value(begin + late * length)
        rise, whole = 2.0 * (levels[1] - levels[0]), (levels[2] - levels[0]) / late
        bend = (whole - rise) / (late - 0.5)
        slope = rise - 0.5 * bend
        segment = Segment(begin, levels[0], slope / length, bend / (length * length))
        pairs = [(value(t), segment.value(t)) for t in (begin + s * length for s in LOOKED_AT)]
        size = max(*(abs(a) for a, _ in pairs), *map(abs, levels))
        if length <= FINEST * (last - first) or all(abs(a - b) <= FITTED * size for a, b in pairs):
            yield segment
        else:
            middle = 0.5 * (begin + end)
            stack += [(middle, end), (begin, middle)]
