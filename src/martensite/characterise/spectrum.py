"""Frequency of a vibration from its record, by a windowed Fourier transform.

The record minus its weighted mean is multiplied by a window and padded with zeros to at least eight times its length.
A parabola through the logarithms of the three highest values interpolates the peak of |X(f)|. Zeros smooth the curve
without new information. For a record of T seconds, frequencies closer than about 2/T [Hz] form one peak, and
`resolution` = 1/T is the spacing of independent values.

The window is the falling half of a Hann window for a decaying vibration, or the whole for a lasting vibration
(`steady`). The peak of a decaying vibration deviates from the damped frequency by a fraction of the order ζ².
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from martensite.base.errors import DataError, ParameterError
from martensite.characterise.estimate import check_columns

LEAST_ROWS = 16
"""Smallest number of rows for a spectrum."""
_CYCLES = 2.0
_CLEAR = 6.0
"""Least peak over median of |X|: white noise of a million rows reaches it in 1 record of 10⁴."""


@dataclass(frozen=True)
class SpectralPeak:
    """The strongest vibration in a record."""

    frequency: float
    """Interpolated frequency of the peak [Hz]."""
    resolution: float
    """1/T, the spacing of independent frequencies [Hz]."""
    amplitude: float
    """Amplitude of a lasting vibration with such a peak, in the unit of the values."""
    prominence: float
    """Peak of |X| over its median within the band."""

    def to_dict(self) -> dict[str, Any]:
        """Return all values by name, for JSON."""
        return asdict(self)


def natural_frequency(
    times: Sequence[float],
    values: Sequence[float],
    *,
    steady: bool = False,
    low: float | None = None,
    high: float | None = None,
) -> SpectralPeak:
    """Return the dominant frequency of a record.

    Args:
        times: times of the rows [s], equally spaced.
        values: vibrating quantity, in any unit.
        steady: True for a vibration that lasts over the record, instead of decaying from its start.
        low: lowest frequency [Hz], by default two cycles in the record.
        high: highest frequency [Hz], by default half the sampling rate.

    Raises:
        ParameterError: `low` and `high` do not leave a band.
        DataError: the rows are too few, not finite or not equally spaced, or no peak is significant.
    """
    step = sampling_interval(times, values)
    count = len(values)
    window = np.hanning(count) if steady else np.hanning(2 * count)[count:]
    signal = np.asarray(values, np.float64)
    signal = window * (signal - np.sum(window * signal) / np.sum(window))
    padded = 8 * 2 ** math.ceil(math.log2(count))
    size = np.abs(np.fft.rfft(signal, padded))
    spacing = 1.0 / (padded * step)
    first, last = _check_band(low, high, 1.0 / (count * step), 0.5 / step)
    inside = slice(math.ceil(first / spacing), math.floor(last / spacing) + 1)
    top = inside.start + int(np.argmax(size[inside]))
    median = float(np.median(size[inside]))
    if top in (inside.start, inside.stop - 1) or size[top] < _CLEAR * median:
        raise DataError(_nothing_found(first, last, float(top * spacing), count * step))
    left, middle, right = np.log(size[top - 1 : top + 2])
    shift = 0.5 * (left - right) / (left - 2.0 * middle + right)
    return SpectralPeak(
        frequency=float((top + shift) * spacing),
        resolution=1.0 / (count * step),
        amplitude=float(2.0 * size[top] / np.sum(window)),
        prominence=float(size[top] / median) if median else math.inf,
    )


def sampling_interval(times: Sequence[float], values: Sequence[float]) -> float:
    """Return the time between rows [s].

    Raises:
        DataError: the rows are too few or not finite, or a time is off by half an interval.
    """
    check_columns("a vibration", "rows", LEAST_ROWS, times=times, values=values)
    step = (times[-1] - times[0]) / (len(times) - 1)
    off = max(abs(time - times[0] - k * step) for k, time in enumerate(times))
    if not off < 0.5 * step:
        raise DataError(
            f"A spectrum needs equally spaced times, but one is {off:.3g} s off the mean "
            f"interval of {step:.3g} s; interpolate the record, or cut it where rows are missing."
        )
    return step


def _check_band(low: float | None, high: float | None, least: float, most: float) -> tuple[float, float]:
    """Return the frequency band [Hz]."""
    first = _CYCLES * least if low is None else low
    last = most if high is None else high
    if not 0.0 < first < last <= most * (1.0 + 1e-9):
        raise ParameterError(
            f"The band must lie between 0 and half the sampling rate, {most:.6g} Hz, but is "
            f"{first:.6g} to {last:.6g} Hz."
        )
    if last - first < 2.0 * least:
        raise ParameterError(
            f"The band of {first:.6g} to {last:.6g} Hz is narrower than two steps of the resolution, {least:.3g} Hz."
        )
    return first, min(last, most)


def _nothing_found(low: float, high: float, at: float, length: float) -> str:
    return (
        f"No vibration stands out between {low:.4g} and {high:.4g} Hz in a record of "
        f"{length:.4g} s: the largest value is at {at:.4g} Hz, at an end of the band or not above "
        "noise; record longer, begin after the release, or choose another band."
    )
