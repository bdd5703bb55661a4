"""Logarithmic decrement, damping ratio and frequency from a record of free vibration.

A released mass on a spring with viscous damping turns at intervals of half a period T_d. Its distance from the mean
position falls by the same factor each time:

    e_k = x₀ ± a exp(-δ k/2),    t_k = t₀ + k T_d/2,
    δ = ln(a_j/a_{j+1}) = 2 π ζ/√(1 - ζ²),    ζ = δ/√(4 π² + δ²),
    f_d = 1/T_d,    f_n = f_d/√(1 - ζ²).

Each extreme belongs to a decaying sinusoid fitted to the rows within T_d/4, which averages noise. Its decay and
frequency come from a first pass. x₀, a and δ are fitted to all extremes together, so an offset of the sensor has no
effect, and extremes near the noise have little weight. Standard errors come from the scatter about this curve, and
about the line of t_k weighted by amplitude.

In use: k = F/x or 3 E I/l³; M = k/ω_n²; c = 2 ζ √(k M).
Source: Kossoski (2018), Appendix A, with f_d distinguished from f_n.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.base.confidence import LEVEL
from martensite.base.errors import DataError, ParameterError
from martensite.characterise.estimate import MeasuredValue, propagate_errors
from martensite.characterise.extremes import Extremes, find_extremes
from martensite.characterise.regression import fit_residuals

LEAST_SHARE = 0.05
"""Smallest extreme used, as a fraction of the first."""
FEWEST_PEAKS = 3


@dataclass(frozen=True)
class LogDecrement:
    """Decay of a free vibration."""

    decrement: MeasuredValue
    """δ, natural logarithm of the ratio of amplitudes one period apart [-]."""
    period: MeasuredValue
    """T_d [s]."""
    offset: MeasuredValue
    """Mean position x₀, in the unit of the values."""
    amplitude: MeasuredValue
    """a, amplitude at the first extreme, in the unit of the values."""
    extremes: Extremes
    """Fitted extremes."""

    @property
    def zeta(self) -> MeasuredValue:
        """Return the damping ratio [-]."""
        return propagate_errors(damping_ratio, self.decrement)

    @property
    def damped_frequency(self) -> MeasuredValue:
        """Return f_d [Hz]."""
        return propagate_errors(lambda period: 1.0 / period, self.period)

    @property
    def frequency(self) -> MeasuredValue:
        """Return the natural frequency f_n of the undamped vibration [Hz]."""
        return propagate_errors(
            lambda period, delta: math.sqrt(1.0 + (delta / (2.0 * math.pi)) ** 2) / period, self.period, self.decrement
        )

    @property
    def cycles(self) -> float:
        """Return the cycles from the first to the last extreme used."""
        return 0.5 * (len(self.extremes.values) - 1)

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """Return all values by name, for JSON."""
        names = ("decrement", "zeta", "damped_frequency", "frequency", "offset", "amplitude")
        return {name: getattr(self, name).to_dict(level) for name in names} | {
            "cycles": self.cycles,
            "noise": self.extremes.noise,
            "extreme_times": list(self.extremes.times),
            "extreme_values": list(self.extremes.values),
        }


def log_decrement(
    times: Sequence[float],
    values: Sequence[float],
    *,
    cycles: int | None = None,
    least: float = LEAST_SHARE,
    frequency: float | None = None,
) -> LogDecrement:
    """Fit the decay of a free vibration.

    Args:
        times: times of the rows [s], equally spaced, from the release on.
        values: vibrating quantity, in any unit, with any offset.
        cycles: number of cycles used, by default all.
        least: smallest extreme used, as a fraction of the first. Extremes below the noise are also omitted.
        frequency: approximate frequency [Hz], by default from the spectrum.

    Raises:
        ParameterError: `cycles`, `least` or `frequency` is invalid.
        DataError: the rows are not a vibration, or have fewer than three peaks.
    """
    if cycles is not None and cycles < FEWEST_PEAKS - 1:
        raise ParameterError(f"Argument `cycles` must be at least {FEWEST_PEAKS - 1}, but is {cycles}.")
    if not 0.0 <= least < 1.0:
        raise ParameterError(f"Argument `least` must be from 0 to below 1, but is {least:g}.")
    first = _fit_extremes(find_extremes(times, values, cycles=cycles, least=least, frequency=frequency))
    period = first.period.value
    again = find_extremes(
        times, values, cycles=cycles, least=least, frequency=1.0 / period, decay=first.decrement.value / period
    )
    return _fit_extremes(again)


def _fit_extremes(extremes: Extremes) -> LogDecrement:
    """Return the exponential through extremes."""
    peaks = (len(extremes.values) + 1) // 2
    if peaks < FEWEST_PEAKS:
        raise DataError(
            f"A logarithmic decrement needs at least {FEWEST_PEAKS} peaks, but "
            f"{peaks} {'was' if peaks == 1 else 'were'} found; record longer, begin right after "
            "the release, or use smaller extremes."
        )
    offset, amplitude, ratio = _fit_decay(extremes)
    return LogDecrement(
        decrement=propagate_errors(lambda r: -2.0 * math.log(r), ratio),
        period=_fit_period(extremes, ratio.value),
        offset=offset,
        amplitude=amplitude,
        extremes=extremes,
    )


def _fit_decay(extremes: Extremes) -> tuple[MeasuredValue, MeasuredValue, MeasuredValue]:
    """Fit x₀, a and the ratio exp(-δ/2) of e_k = x₀ + s_k a ratio^k."""
    count, values = len(extremes.values), np.asarray(extremes.values)
    middle, size = 0.5 * (values[0] + values[1]), 0.5 * abs(values[0] - values[1])
    last = 0.5 * abs(values[-1] - values[-2])
    steps = np.arange(count)
    signs, shares = extremes.first_sign * (-1.0) ** steps, (values - middle) / size

    def residuals(guess: tuple[float, ...]) -> Any:
        shift, amplitude, ratio = guess
        return shares - shift - signs * amplitude * ratio**steps

    start = 0.0, 1.0, float(last / size) ** (1.0 / (count - 2))
    shift, amplitude, ratio = fit_residuals(residuals, start).estimates
    return shift.scaled(size, middle), amplitude.scaled(size), ratio


def _fit_period(extremes: Extremes, ratio: float) -> MeasuredValue:
    """Fit T_d to the times of half cycles, weighted by amplitude."""
    times = np.asarray(extremes.times) - extremes.times[0]
    steps = np.arange(len(times))

    def residuals(line: tuple[float, ...]) -> Any:
        first, half = line
        return (times / times[1] - first - half * steps) * ratio**steps

    return fit_residuals(residuals, (0.0, 1.0)).estimates[1].scaled(2.0 * times[1])


# ---------------------------------------------------------------- a mass on a spring


def damping_ratio(decrement: float) -> float:
    """Return ζ = δ/√(4 π² + δ²) [-]."""
    return decrement / math.hypot(2.0 * math.pi, decrement)


def compute_natural_frequency(stiffness: float, mass: float) -> float:
    """Return the natural frequency √(k/M)/(2 π) [Hz] from stiffness [N/m] and moving mass [kg]."""
    return math.sqrt(stiffness / mass) / (2.0 * math.pi)


def moving_mass(stiffness: float, frequency: float) -> float:
    """Return M = k/(2 π f_n)² [kg] from stiffness [N/m] and natural frequency [Hz]."""
    return stiffness / (2.0 * math.pi * frequency) ** 2
