"""Moving average over an odd number of rows, and what it does to a vibration.

    y_i = (1/w) Σ x_{i+j},  j = -(w-1)/2 … (w-1)/2,    gain(f) = sin(π f w Δt)/(w sin(π f Δt))

The window is centred: nothing is shifted in time, but a vibration of frequency f is multiplied by
the gain, which falls to 0 at f = 1/(w Δt) and is negative, peaks turned into valleys, above. Near
the ends the window shrinks to what fits on both sides; the first and last (w-1)/2 values are
averaged over fewer rows, and the very first and last are the record's own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from martensite.base.errors import DataError, ParameterError


def average_moving(values: Sequence[float], window: int) -> list[float]:
    """Centred moving average, as long as the record, in its unit.

    Args:
        values: equally spaced rows.
        window: number of rows averaged, odd.

    Raises:
        ParameterError: the window is not an odd number above 0.
        DataError: the window is longer than the record.
    """
    _check_window(window)
    if window > len(values):
        raise DataError(f"A window of {window} rows is longer than the record of {len(values)} rows.")
    reach, last = (window - 1) // 2, len(values) - 1
    means: list[float] = []
    for i in range(len(values)):
        side = min(reach, i, last - i)
        means.append(math.fsum(values[i - side : i + side + 1]) / (2 * side + 1))
    return means


def moving_average_gain(frequency: float, window: int, interval: float) -> float:
    """Factor on a vibration of some frequency, away from the ends [-].

    Args:
        frequency: of the vibration [Hz].
        window: number of rows averaged, odd.
        interval: time between rows [s].

    Raises:
        ParameterError: the window is not an odd number above 0, or the interval not above 0.
    """
    _check_window(window)
    if not 0.0 < interval < math.inf:
        raise ParameterError(f"Argument `interval` must be above 0 s, but is {interval:g} s.")
    angle = math.pi * math.remainder(frequency * interval, 1.0)
    if angle == 0.0:  # as many whole cycles from row to row: the rows do not see it
        return 1.0
    return math.sin(window * angle) / (window * math.sin(angle))


def _check_window(window: int) -> None:
    if window < 1 or window % 2 == 0:
        raise ParameterError(
            f"Argument `window` must be an odd number of rows above 0, but is {window}; an even "
            "window would shift the record by half a row."
        )
