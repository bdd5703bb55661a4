"""Film coefficients of a heated wire from steady states, and polynomials in temperature.

Every steady state gives

    h = P/[S (T - T_a)],    S = π d l,    P = V²/R = V I,

with the power P in the wire, its lateral surface S and the ambient temperature T_a. The measured values are the flux
P/S and T. Points keep their ambient temperature, so that they can be recomputed for another ambient.

The film coefficient is h = Σ h_k θ^k, by least squares. The power is well known; the temperature has noise of one size
e at all points, which changes h by -h e/(T - T_a), most at low power. With a known ambient, `fit_film_points` therefore
minimises the squares of the temperatures at the measured fluxes. `fit_film` minimises the squares of h.

θ is the temperature in °C, as in the cooling model `polynomial` with its default reference. k runs over the requested
`terms`; other coefficients are zero. With residuals r over n points and p terms,

    R² = 1 - Σ r²/Σ (h - mean h)²,    adjusted R² = 1 - (1 - R²) (n - 1)/(n - p),
    AICc = n ln(Σ r²/n) + 2 (p + 1) + 2 (p + 1) (p + 2)/(n - p - 2).

R² never falls with a further term. If the term is not worthwhile, adjusted R² falls and AICc (Hurvich and Tsai 1989)
rises. Intervals: see `martensite.characterise.regression`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from martensite.base.confidence import LEVEL, Interval
from martensite.base.errors import DataError, ParameterError
from martensite.characterise.estimate import check_columns
from martensite.characterise.regression import LinearFit, fit_noisy_abscissae, fit_powers

ABSOLUTE_ZERO = -273.15
"""[°C]"""


@dataclass(frozen=True)
class FilmPoints:
    """Film coefficients at temperatures, with the assumed ambient temperature."""

    temperatures_degC: tuple[float, ...]
    """Steady temperatures [°C]."""
    h: tuple[float, ...]
    """Film coefficients [W/(m² K)]."""
    ambient_degC: float | None = None
    """Ambient temperature [°C]; None if unknown."""

    def __post_init__(self) -> None:
        """Raise `DataError` if a point does not belong to a wire heated above its ambient."""
        columns = {"temperatures": self.temperatures_degC, "film_coefficients": self.h}
        check_columns("a wire", "points", 2, **columns)
        if min(self.h) <= 0.0:
            raise DataError(f"Film coefficients must be above 0, but one is {min(self.h):.6g}.")
        if self.ambient_degC is not None:
            _check_ambient(self.ambient_degC, self.temperatures_degC)

    def __len__(self) -> int:
        return len(self.h)

    @property
    def ambient(self) -> float:
        """Return the ambient temperature [°C].

        Raises:
            DataError: the ambient temperature is unknown.
        """
        if self.ambient_degC is None:
            raise DataError("The ambient temperature of these film coefficients is not known.")
        return self.ambient_degC

    @property
    def fluxes(self) -> tuple[float, ...]:
        """Return the measured heat flux P/S [W/m²], which does not depend on the ambient."""
        pairs = zip(self.temperatures_degC, self.h, strict=True)
        return tuple(h * (at - self.ambient) for at, h in pairs)

    def at_ambient(self, ambient_degC: float) -> FilmPoints:
        """Return the points with the same fluxes and temperatures for another ambient [°C]."""
        _check_ambient(ambient_degC, self.temperatures_degC)
        return FilmPoints(
            self.temperatures_degC,
            tuple(flux / (at - ambient_degC) for at, flux in zip(self.temperatures_degC, self.fluxes, strict=True)),
            ambient_degC,
        )

    def to_dict(self) -> dict[str, Any]:
        """Return all values by name, for JSON."""
        return {name: list(v) if isinstance(v, tuple) else v for name, v in vars(self).items()}


def compute_film_points(
    temperatures_degC: Sequence[float], powers: Sequence[float], *, diameter: float, length: float, ambient_degC: float
) -> FilmPoints:
    """Return the film coefficients of a wire from steady temperatures and heating powers.

    Args:
        temperatures_degC: steady temperatures [°C].
        powers: heating powers [W].
        diameter: diameter of the wire [m].
        length: length of the wire [m].
        ambient_degC: ambient temperature [°C].

    Raises:
        ParameterError: the diameter or the length is not above 0.
        DataError: the points are not of a wire heated above its ambient.
    """
    if not (0.0 < diameter < math.inf and 0.0 < length < math.inf):
        raise ParameterError(f"Diameter and length must be above 0 m, but are {diameter:g} m and {length:g} m.")
    check_columns("a wire", "points", 2, temperatures=temperatures_degC, powers=powers)
    _check_ambient(ambient_degC, temperatures_degC)
    surface = math.pi * diameter * length
    pairs = zip(temperatures_degC, powers, strict=True)
    h = tuple(power / (surface * (at - ambient_degC)) for at, power in pairs)
    return FilmPoints(tuple(temperatures_degC), h, ambient_degC)


def powers_from_voltage(voltages: Sequence[float], resistances: Sequence[float] | float) -> list[float]:
    """Return the heating powers V²/R [W] from voltages [V] and one resistance, or one per voltage [ohm].

    Raises:
        ParameterError: a resistance is not above 0.
        DataError: resistances and voltages differ in length.
    """
    each = [resistances] * len(voltages) if isinstance(resistances, (int, float)) else resistances
    if len(each) != len(voltages):
        raise DataError(f"There must be one resistance per voltage, but there are {len(each)} and {len(voltages)}.")
    if not all(ohms > 0.0 for ohms in each):
        raise ParameterError(f"A resistance must be above 0 ohm, but one is {min(each):g} ohm.")
    return [volts * volts / ohms for volts, ohms in zip(voltages, each, strict=True)]


def _check_ambient(ambient: float, temperatures: Sequence[float]) -> None:
    coldest = min(temperatures)
    if not ABSOLUTE_ZERO <= ambient < coldest:
        raise DataError(
            f"The ambient temperature must be below the coldest point, {coldest:g} degC, but is {ambient:g} degC."
        )


FORMS: dict[str, tuple[int, ...]] = {"constant": (0,), "linear": (0, 1), "quadratic": (0, 1, 2), "h1=0": (0, 2)}
"""Name of a form -> its powers of the temperature."""


@dataclass(frozen=True)
class FilmFit:
    """Fitted polynomial, with its explained fraction of the variance and its errors."""

    coefficients: tuple[float, ...]
    """h₀ [W/(m² K)], h₁ [W/(m² K²)], h₂ [W/(m² K³)], … for temperatures in °C."""
    r_squared: float
    adjusted: float
    """Adjusted R²; NaN unless there are more points than terms."""
    linear: LinearFit
    """Linear fit with its covariance."""

    @property
    def terms(self) -> tuple[int, ...]:
        """Return the fitted powers of the temperature."""
        return self.linear.terms

    @property
    def deviation(self) -> float:
        """Return the standard deviation of the temperatures [K], or of h [W/(m² K)] for an unknown ambient."""
        return self.linear.deviation

    @property
    def aicc(self) -> float:
        """Return the Akaike criterion, corrected for few points; NaN for too few points."""
        n, p = self.linear.points, len(self.terms) + 1
        if n - p < 2 or self.linear.squares == 0.0:
            return math.nan
        return n * math.log(self.linear.squares / n) + 2.0 * p + 2.0 * p * (p + 1) / (n - p - 1)

    def film(self, temperature_degC: float) -> float:
        """Return the film coefficient [W/(m² K)] at a temperature [°C]."""
        return film_value(self.coefficients, temperature_degC)

    def error(self, term: int) -> float:
        """Return the standard error of the coefficient of a power of the temperature."""
        return self.linear.error(term)

    def interval(self, term: int, level: float = LEVEL) -> Interval:
        """Return the confidence interval of the coefficient of a power of the temperature."""
        return self.linear.interval(term, level)

    def half_width(self, temperature_degC: float, level: float = LEVEL) -> float:
        """Return half the confidence band of h [W/(m² K)] at a temperature [°C]."""
        return self.linear.half_width(temperature_degC, level)

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """Return all values by name, for JSON; coefficients by power."""
        return {
            "coefficients": list(self.coefficients),
            "terms": list(self.terms),
            "standard_errors": {str(k): self.error(k) for k in self.terms},
            "intervals": {str(k): list(self.interval(k, level)) for k in self.terms},
            "p_values": {str(k): self.linear.p_value(k) for k in self.terms},
            "r_squared": self.r_squared,
            "adjusted": self.adjusted,
            "aicc": self.aicc,
            "deviation": self.deviation,
        }


def check_film_points(temperatures_degC: Sequence[float], h: Sequence[float]) -> None:
    """Raise `DataError` unless there are at least two finite points."""
    columns = {"temperatures": temperatures_degC, "film_coefficients": h}
    check_columns("a wire", "points", 2, **columns)


def film_value(coefficients: Sequence[float], temperature_degC: float) -> float:
    """Return the film coefficient [W/(m² K)] of a polynomial at a temperature [°C]."""
    return sum(c * temperature_degC**k for k, c in enumerate(coefficients))


def film_r_squared(temperatures_degC: Sequence[float], h: Sequence[float], coefficients: Sequence[float]) -> float:
    """Return R² of a given polynomial on given points: temperatures [°C], h [W/(m² K)].

    Raises:
        DataError: the points are too few, or all h are equal.
    """
    check_film_points(temperatures_degC, h)
    mean = sum(h) / len(h)
    scatter = sum((value - mean) ** 2 for value in h)
    if scatter == 0.0:
        raise _describe_no_scatter(h)
    points = zip(temperatures_degC, h, strict=True)
    left = sum((value - film_value(coefficients, at)) ** 2 for at, value in points)
    return 1.0 - left / scatter


def _describe_no_scatter(h: Sequence[float]) -> DataError:
    return DataError(f"All {len(h)} film coefficients are {h[0]:.6g}: R² is not defined.")


def fit_film_points(points: FilmPoints, terms: Sequence[int] = (0, 1, 2)) -> FilmFit:
    """Fit a polynomial to film coefficients with equal noise in all temperatures.

    R² is the fraction of the squares about a constant h that the form explains. Without an ambient temperature the fit
    is `fit_film`.

    Args:
        points: steady states.
        terms: fitted powers of the temperature. Other coefficients are zero.

    Raises:
        ParameterError: the terms are not distinct whole numbers from 0 on.
        DataError: the points are too few, or do not determine the terms.
    """
    if points.ambient_degC is None:
        return fit_film(points.temperatures_degC, points.h, terms)
    at, fluxes, ambient = points.temperatures_degC, points.fluxes, points.ambient
    linear, constant = (fit_noisy_abscissae(at, fluxes, one, ambient) for one in (terms, (0,)))
    if constant.squares == 0.0:
        raise _describe_no_scatter(points.h)
    return _score_fit(linear, 1.0 - linear.squares / constant.squares)


def fit_film(temperatures_degC: Sequence[float], h: Sequence[float], terms: Sequence[int] = (0, 1, 2)) -> FilmFit:
    """Fit a polynomial to film coefficients by linear least squares.

    Args:
        temperatures_degC: temperatures of the points [°C].
        h: film coefficients [W/(m² K)].
        terms: fitted powers of the temperature. Other coefficients are zero.

    Raises:
        ParameterError: the terms are not distinct whole numbers from 0 on.
        DataError: the points are too few, not finite, or do not determine the terms.
    """
    check_film_points(temperatures_degC, h)
    linear = fit_powers(temperatures_degC, h, terms)
    return _score_fit(linear, film_r_squared(temperatures_degC, h, _spread_terms(linear)))


def _spread_terms(linear: LinearFit) -> tuple[float, ...]:
    by_power = dict(zip(linear.terms, linear.values, strict=True))
    return tuple(by_power.get(k, 0.0) for k in range(max(linear.terms) + 1))


def _score_fit(linear: LinearFit, r_squared: float) -> FilmFit:
    n, p = linear.points, len(linear.terms)
    adjusted = 1.0 - (1.0 - r_squared) * (n - 1) / (n - p) if n > p else math.nan
    return FilmFit(_spread_terms(linear), r_squared, adjusted, linear)
