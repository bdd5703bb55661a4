"""Film coefficient against temperature: linear least squares of h = Σ h_k θ^k.

θ is the temperature in °C, the form of the cooling model `polynomial` with its default
reference, and k runs over the `terms` asked for; a coefficient that is not asked for is
zero. With residuals r over n points and p terms,

    R² = 1 - Σ r²/Σ (h - mean h)²,    adjusted R² = 1 - (1 - R²) (n - 1)/(n - p).

R² never falls when a term is added; the adjusted one does when the term is not worth it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from martensite.errors import DataError, ParameterError


@dataclass(frozen=True)
class FilmFit:
    """A fitted polynomial, and how much of the scatter it explains."""

    coefficients: tuple[float, ...]
    """h₀ [W/(m² K)], h₁ [W/(m² K²)], h₂ [W/(m² K³)], … for temperatures in °C."""
    r_squared: float
    adjusted: float
    """Adjusted R²; NaN if there are no more points than terms."""

    def film(self, temperature_degC: float) -> float:
        """Film coefficient [W/(m² K)] at a temperature [°C]."""
        return film_value(self.coefficients, temperature_degC)


def film_value(coefficients: Sequence[float], temperature_degC: float) -> float:
    """Film coefficient [W/(m² K)] of a polynomial at a temperature [°C]."""
    h = 0.0
    for coefficient in reversed(coefficients):
        h = h * temperature_degC + coefficient
    return h


def film_r_squared(
    temperatures_degC: Sequence[float], h: Sequence[float], coefficients: Sequence[float]
) -> float:
    """R² of a given polynomial on given points: temperatures [°C], h [W/(m² K)].

    Raises:
        DataError: the points are too few, or all h are equal.
    """
    _check(temperatures_degC, h)
    mean = sum(h) / len(h)
    scatter = sum((value - mean) ** 2 for value in h)
    if scatter == 0.0:
        raise DataError(f"All {len(h)} film coefficients are {h[0]:.6g}: R² is not defined.")
    points = zip(temperatures_degC, h, strict=True)
    left = sum((value - film_value(coefficients, at)) ** 2 for at, value in points)
    return 1.0 - left / scatter


def fit_film(
    temperatures_degC: Sequence[float], h: Sequence[float], terms: Sequence[int] = (0, 1, 2)
) -> FilmFit:
    """Fit a polynomial to film coefficients by linear least squares.

    Args:
        temperatures_degC: temperatures of the points [°C].
        h: film coefficients [W/(m² K)].
        terms: powers of the temperature that are fitted; the others are zero.

    Raises:
        ParameterError: the terms are not distinct whole numbers from 0 on.
        DataError: the points are too few, not finite, or do not determine the terms.
    """
    _check(temperatures_degC, h)
    _check_terms(terms)
    coefficients = _least_squares(temperatures_degC, h, terms)
    r_squared = film_r_squared(temperatures_degC, h, coefficients)
    n, p = len(h), len(terms)
    adjusted = 1.0 - (1.0 - r_squared) * (n - 1) / (n - p) if n > p else math.nan
    return FilmFit(coefficients, r_squared, adjusted)


def _least_squares(
    temperatures: Sequence[float], h: Sequence[float], terms: Sequence[int]
) -> tuple[float, ...]:
    import numpy as np

    scale = max(abs(t) for t in temperatures) or 1.0
    at = np.asarray(temperatures, np.float64) / scale
    columns = np.stack([at**k for k in terms], axis=1)
    found, _, rank, _ = np.linalg.lstsq(columns, np.asarray(h, np.float64))
    if rank < len(terms):
        raise DataError(
            f"{len(set(temperatures))} different temperatures do not determine "
            f"{len(terms)} coefficients; measure at more, or fit fewer terms."
        )
    by_power = dict(zip(terms, found.tolist(), strict=True))
    return tuple(by_power.get(k, 0.0) / scale**k for k in range(max(terms) + 1))


def _check(temperatures: Sequence[float], h: Sequence[float]) -> None:
    if len(temperatures) != len(h):
        raise DataError(
            f"Temperatures and film coefficients must be equally many, "
            f"but are {len(temperatures)} and {len(h)}."
        )
    if len(h) < 2:
        raise DataError(f"A fit needs at least 2 points, but has {len(h)}.")
    if not all(math.isfinite(number) for number in (*temperatures, *h)):
        raise DataError("Temperatures and film coefficients must be finite, but are not all.")


def _check_terms(terms: Sequence[int]) -> None:
    if not terms or len(set(terms)) != len(terms) or min(terms) < 0:
        raise ParameterError(
            f"Argument `terms` must be distinct powers from 0 on, but is {tuple(terms)}."
        )
