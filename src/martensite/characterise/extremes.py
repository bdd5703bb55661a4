"""Successive extremes of a free vibration, each from the neighbouring rows.

The first extreme is farthest from the later mean of the record. Each further extreme is sought half a period later, on
the other side. A plateau before the release and a maximum cut by the start have no vertex and are skipped.

`scipy.signal.find_peaks` is unsuitable: with noise of 30 % of the amplitude its highest rows are half a lobe off. The
chain then breaks after a few cycles, and standard errors grow tenfold.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.base.errors import DataError, ParameterError
from martensite.characterise.spectrum import natural_frequency, sampling_interval

FEWEST_ROWS = 10
"""Least number of rows per cycle."""
_CLEAR = 8.0
"""Least size of an extreme, in its standard errors."""
_ROUND = 0.6
"""Least amplitude about the first extreme, as a fraction of its distance from the mean position."""


@dataclass(frozen=True)
class Extremes:
    """Alternating extremes of a vibration."""

    times: tuple[float, ...]
    """[s]"""
    values: tuple[float, ...]
    """In the unit of the record, offset included."""
    first_sign: float
    """1 if the first is a maximum, -1 if a minimum."""
    noise: float
    """Standard deviation of the rows about the sinusoids."""


@dataclass(frozen=True)
class _Vertex:
    """Extreme of a sinusoid through the rows within a quarter of a period."""

    time: float
    value: float
    size: float
    """Amplitude of the sinusoid."""
    squares: float
    """Sum of the squared residuals."""
    freedom: int


def find_extremes(
    times: Sequence[float],
    values: Sequence[float],
    *,
    cycles: int | None,
    least: float,
    frequency: float | None,
    decay: float = 0.0,
) -> Extremes:
    """Return the extremes of a vibration, at most two per requested cycle.

    Args:
        times: times of the rows [s], equally spaced.
        values: vibrating quantity.
        cycles: largest number of cycles, or None for all.
        least: smallest extreme, as a fraction of the first.
        frequency: approximate frequency [Hz], or None for the frequency of the spectrum.
        decay: decay rate of the amplitude within a half cycle [1/s].

    Raises:
        ParameterError: `frequency` is not above 0.
        DataError: the rows are not a vibration, or are too far apart.
    """
    step = sampling_interval(times, values)
    if frequency is None:
        frequency = natural_frequency(times, values).frequency
    if not frequency > 0.0:
        raise ParameterError(f"Argument `frequency` must be above 0 Hz, but is {frequency:g} Hz.")
    if frequency * step * FEWEST_ROWS > 1.0:
        raise DataError(
            f"A vibration of {frequency:.4g} Hz needs at least {FEWEST_ROWS} rows per cycle, but "
            f"has {1.0 / (frequency * step):.3g}; sample faster."
        )
    scan = _Scan(np.asarray(times, np.float64), np.asarray(values, np.float64), frequency, decay)
    most = len(values) if cycles is None else 2 * cycles + 1
    return scan.run(most, least)


class _Scan:
    """Search along a record from extreme to extreme."""

    def __init__(self, times: Any, values: Any, frequency: float, decay: float) -> None:
        self.times, self.values = times, values
        self.alpha = 0.5 * decay / (math.pi * frequency)
        self.half = 0.5 / frequency
        self.rest = float(values[len(values) // 2 :].mean())

    def run(self, most: int, least: float) -> Extremes:
        """Return the extremes until they are too small, the limit is reached, or the record ends."""
        sign, vertex = self._first()
        vertices: list[_Vertex] = []
        first_sign = sign
        while vertex is not None and len(vertices) < most and self._clear(vertices, vertex, least):
            vertices.append(vertex)
            sign = -sign
            vertex = self._vertex(vertex.time + self.half, sign)
        return Extremes(
            tuple(v.time for v in vertices), tuple(v.value for v in vertices), first_sign, _estimate_noise(vertices)
        )

    def _first(self) -> tuple[float, _Vertex | None]:
        """Return the largest extreme with a vertex, and its sign."""
        start = float(self.times[0])
        while start < self.times[-1]:
            rows = self.times >= start
            away = (self.values - self.rest)[rows]
            place = int(abs(away).argmax())
            sign = 1.0 if away[place] > 0.0 else -1.0
            vertex = self._vertex(float(self.times[rows][place]), sign)
            if vertex is not None and self._round(vertex):
                return sign, vertex
            start = max(start, float(self.times[rows][place])) + 0.5 * self.half
        return 1.0, None

    def _round(self, vertex: _Vertex) -> bool:
        """Return whether a vertex belongs to a vibration, and not to the end of a hold."""
        return vertex.size >= _ROUND * abs(vertex.value - self.rest)

    def _vertex(self, centre: float, sign: float) -> _Vertex | None:
        """Return the extreme of a sinusoid about a time, centred on itself; None without an extreme."""
        vertex = None
        for _ in range(3):
            reach = 0.5 * self.half
            if not self.times[0] <= centre - reach <= centre + reach <= self.times[-1]:
                return None
            vertex = self._sinusoid(centre, sign)
            if vertex is None:
                return None
            centre = vertex.time
        return vertex

    def _sinusoid(self, centre: float, sign: float) -> _Vertex | None:
        rows = abs(self.times - centre) <= 0.5 * self.half
        angle = (self.times[rows] - centre) * math.pi / self.half
        fall = np.exp(-self.alpha * angle)
        columns = np.stack([np.ones_like(angle), fall * np.cos(angle), fall * np.sin(angle)], axis=1)
        fitted, *_ = np.linalg.lstsq(columns, self.values[rows], rcond=None)
        level, even, odd = map(float, fitted)
        if not sign * even > abs(odd):
            return None
        at = math.atan((odd - self.alpha * even) / (even + self.alpha * odd))
        value = math.exp(-self.alpha * at) * (even * math.cos(at) + odd * math.sin(at))
        left = self.values[rows] - columns @ fitted
        return _Vertex(
            time=centre + at * self.half / math.pi,
            value=level + value,
            size=abs(value),
            squares=float(left @ left),
            freedom=len(angle) - 3,
        )

    def _clear(self, vertices: list[_Vertex], vertex: _Vertex, least: float) -> bool:
        """Return whether an extreme is above the noise and large enough compared with the first."""
        if not vertices:
            return True
        size = 0.5 * abs(vertex.value - vertices[-1].value)
        error = _estimate_noise([*vertices, vertex]) * math.sqrt(3.0 / (vertex.freedom + 3))
        return size >= max(least * vertices[0].size, _CLEAR * error)


def _estimate_noise(vertices: list[_Vertex]) -> float:
    """Return the standard deviation of the rows about the sinusoids."""
    freedom = sum(vertex.freedom for vertex in vertices)
    return math.sqrt(sum(vertex.squares for vertex in vertices) / freedom) if freedom else 0.0
