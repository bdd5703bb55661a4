"""What a film coefficient owes to the ambient temperature that it was computed with.

A steady state holds a temperature θ and a flux q = h (θ - a); h follows only once the ambient a
is given, and moves with it by dh/da = h/(θ - a): most for the coldest point. A slope of h over θ
and a shift of a therefore make up for each other in part; how far is told by the sensitivities of
q to the level of h, to its slope and to a at the points.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from martensite.base.confidence import LEVEL
from martensite.characterise.film_coefficient import FORMS, FilmFit, fit_film
from martensite.characterise.film_points import ABSOLUTE_ZERO, FilmPoints
from martensite.characterise.polynomial_regression import fit_powers

SHIFTS = (-2.5, -1.0, 0.0, 1.0, 2.5)
"""Ambient temperatures tried, less the given one [K]."""


@dataclass(frozen=True)
class AtAmbient:
    """The points and their straight line had the ambient been another one."""

    points: FilmPoints
    line: FilmFit

    @property
    def mean(self) -> float:
        """Mean film coefficient [W/(m² K)]."""
        return sum(self.points.h) / len(self.points)

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """All numbers by name, for JSON."""
        return self.points.to_dict() | {"mean": self.mean, "linear": self.line.to_dict(level)}


def shift_ambients(points: FilmPoints, shifts: tuple[float, ...] = SHIFTS) -> list[AtAmbient]:
    """The points and their lines at ambient temperatures that differ by `shifts` [K].

    An ambient that is not below the coldest point is left out.
    """
    coldest = min(points.temperatures_degC)
    ambients = [points.ambient + shift for shift in shifts]
    moved = [points.at_ambient(a) for a in ambients if ABSOLUTE_ZERO <= a < coldest]
    return [AtAmbient(p, fit_film(p.temperatures_degC, p.h, FORMS["linear"])) for p in moved]


def film_per_kelvin(points: FilmPoints) -> tuple[float, ...]:
    """dh/dT_a = h/(T - T_a) of every point [W/(m² K²)]."""
    pairs = zip(points.temperatures_degC, points.h, strict=True)
    return tuple(h / (at - points.ambient) for at, h in pairs)


def slope_per_kelvin(points: FilmPoints) -> float:
    """Derivative of the slope of h(T) with respect to the ambient [W/(m² K³)]."""
    line = fit_powers(points.temperatures_degC, film_per_kelvin(points), FORMS["linear"])
    return line.values[1]


def find_level_ambient(points: FilmPoints) -> float:
    """Ambient temperature [°C] at which the straight line through h is level; NaN if none."""
    from scipy.optimize import root_scalar

    coldest = min(points.temperatures_degC)

    def slope(ambient: float) -> float:
        moved = points.at_ambient(ambient)
        return fit_powers(moved.temperatures_degC, moved.h, FORMS["linear"]).values[1]

    low, high = ABSOLUTE_ZERO, coldest - 1e-6
    if slope(low) <= 0.0 or slope(high) >= 0.0:
        return math.nan
    return root_scalar(slope, bracket=(low, high), xtol=1e-12).root


@dataclass(frozen=True)
class Confounding:
    """How far the ambient, the level and the slope of h can be told apart at the points."""

    correlation: float
    """Of the estimates of slope and ambient; ±1 if one makes up for the other entirely."""
    condition: float
    """Condition number of the scaled sensitivities; 1 if they are independent."""


def find_confounding(points: FilmPoints) -> Confounding:
    """Sensitivities of the flux to level and slope of h and to the ambient, at the line fitted."""
    import numpy as np

    at = np.asarray(points.temperatures_degC)
    line = fit_film(points.temperatures_degC, points.h, FORMS["linear"])
    over = at - points.ambient
    film = np.asarray([line.film(float(t)) for t in at])
    columns = np.stack([over, (at - at.mean()) * over, -film], axis=1)
    columns /= np.linalg.norm(columns, axis=0)
    sizes = np.linalg.svd(columns, compute_uv=False)
    if len(at) < 3 or sizes[-1] <= np.finfo(float).eps * sizes[0]:
        return Confounding(math.nan, math.inf)
    covariance = np.linalg.inv(columns.T @ columns)
    both = covariance[1, 2] / math.sqrt(covariance[1, 1] * covariance[2, 2])
    return Confounding(float(both), float(sizes[0] / sizes[-1]))
