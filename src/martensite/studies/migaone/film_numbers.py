"""Numbers of the film coefficient: the fit of h(T) to Table 2, and its consequences."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace
from typing import Any

from martensite.characterise.film_coefficient import FilmFit, film_r_squared, fit_film
from martensite.physics.thermal.films import PolynomialCooling
from martensite.studies.migaone import bench
from martensite.studies.tables import Printed

OTHER_AMBIENT = 41.0
"""Another ambient temperature for a sensitivity [°C]."""
ROUNDING = 0.25
"""Rounding error of the temperatures of Table 2, mostly printed in steps of 0.5 K [K]."""


def compute_film(printed: Printed) -> dict[str, Any]:
    """Return the fit, the steady temperatures, and the influence of the ambient temperature."""
    constant = steady_errors("constant", printed)
    films = films_at_ambient(OTHER_AMBIENT, printed)
    tilted = fit_film(printed.steps.column("temperature"), films, terms=(0, 1))
    errors = steady_errors("polynomial", printed)
    return {
        "rounding": ROUNDING,
        "margin": rounding_margin(printed),
        "quadratic": _name_coefficients(fit_quadratic(printed)),
        "no_linear": _name_coefficients(no_linear(printed)),
        "line": _name_coefficients(fit_straight(printed)),
        "r2_printed": printed_r_squared(printed),
        "steady": [
            vars(step) | {"found": step.temperature + error} for step, error in zip(printed.steps, errors, strict=True)
        ],
        "steady_error": max(map(abs, errors)),
        "steady_constant_h": max(constant, key=abs),
        "constant_errors": ", ".join(f"{error:+.1f}" for error in constant),
        "ambient_sensitivity": tilted.coefficients[1],
        "other_ambient": OTHER_AMBIENT,
        "other_films": ", ".join(f"{h:.1f}" for h in films),
    }


def _name_coefficients(fit: FilmFit) -> SimpleNamespace:
    named = {f"h{k}": h for k, h in enumerate(fit.coefficients)}
    return SimpleNamespace(**named, r_squared=fit.r_squared, adjusted=fit.adjusted)


def _table_points(printed: Printed) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the temperatures [°C] and film coefficients of Table 2."""
    return printed.steps.column("temperature"), printed.steps.column("film")


def fit_quadratic(printed: Printed) -> FilmFit:
    """Return all three coefficients fitted to Table 2."""
    return fit_film(*_table_points(printed))


def no_linear(printed: Printed) -> FilmFit:
    """Return the fit of constant and square, which the printed coefficients suggest."""
    return fit_film(*_table_points(printed), terms=(0, 2))


def rounding_margin(printed: Printed) -> float:
    """Return the largest change of h₀ of `no_linear` by rounding of the printed temperatures [W/(m² K)]."""
    temperatures, films = _table_points(printed)
    fits = (
        fit_film([t + sign * ROUNDING for t, sign in zip(temperatures, signs, strict=True)], films, terms=(0, 2))
        for signs in product((-1.0, 1.0), repeat=len(films))
    )
    middle = no_linear(printed).coefficients[0]
    return max(abs(fit.coefficients[0] - middle) for fit in fits)


def fit_straight(printed: Printed) -> FilmFit:
    """Return the fit of a straight line."""
    return fit_film(*_table_points(printed), terms=(0, 1))


def printed_r_squared(printed: Printed) -> float:
    """Return R² of the printed coefficients on the printed points."""
    coefficients = printed.h0, printed.h1, printed.h2
    return film_r_squared(*_table_points(printed), coefficients)


def films_at_ambient(ambient: float, printed: Printed) -> list[float]:
    """Return the film coefficients of Table 2 for another ambient temperature [°C]."""
    return [step.film * (step.temperature - printed.ambient) / (step.temperature - ambient) for step in printed.steps]


def refit_film(printed: Printed) -> PolynomialCooling:
    """Return the film coefficient fitted with h₁ = 0."""
    h0, h1, h2 = no_linear(printed).coefficients
    return PolynomialCooling(h0=h0, h1=h1, h2=h2)


COOLINGS = {"polynomial": bench.printed_film, "refitted": refit_film, "constant": bench.mean_constant}


def steady_errors(cooling: str, printed: Printed) -> list[float]:
    """Return simulated less printed steady temperatures with one of `COOLINGS` [K]."""
    model = COOLINGS[cooling](printed)
    return [
        bench.steady_temperature(model, bench.heating_power(step, printed)) - step.temperature for step in printed.steps
    ]
