"""Claims on the film coefficient: the fit of h(T) to Table 2, and what follows from it."""

from __future__ import annotations

from martensite.characterise.film_coefficient import FilmFit, film_r_squared, fit_film
from martensite.studies.base import Claim
from martensite.studies.migaone import bench
from martensite.studies.migaone.printed import PAPER, Printed
from martensite.thermal.polynomial import PolynomialCooling

FIT = f"{PAPER}, section 3, text after Table 2"
TABLE_2 = f"{PAPER}, Table 2"
OTHER_AMBIENT = 41.0
"""Another ambient temperature, to see what rests on the printed one [°C]."""
ALLOWED = 0.5
"""Largest difference of a steady temperature that counts as agreement [K]."""


def claims(printed: Printed) -> list[Claim]:
    """The fit, the steady temperatures, the influence of the ambient temperature."""
    return [*_fits(printed), *_steady(printed), *_ambient(printed)]


def quadratic(printed: Printed) -> FilmFit:
    """All three coefficients fitted to Table 2."""
    return fit_film(printed.temperatures, printed.films)


def no_linear(printed: Printed) -> FilmFit:
    """Constant and square fitted, as the printed coefficients suggest was done."""
    return fit_film(printed.temperatures, printed.films, terms=(0, 2))


def straight(printed: Printed) -> FilmFit:
    """A straight line fitted."""
    return fit_film(printed.temperatures, printed.films, terms=(0, 1))


def printed_r_squared(printed: Printed) -> float:
    """R² that the printed coefficients have on the printed points."""
    return film_r_squared(printed.temperatures, printed.films, printed.coefficients)


def films_at_ambient(ambient: float, printed: Printed) -> list[float]:
    """Table 2's film coefficients had the ambient temperature been another one [°C]."""
    return [
        step.film * (step.temperature - printed.ambient) / (step.temperature - ambient)
        for step in printed.steps
    ]


def _fits(printed: Printed) -> list[Claim]:
    full, even, line = quadratic(printed), no_linear(printed), straight(printed)
    optimum = "unique optimum of linear least squares on the four printed points"
    h, t, t2 = "W/m^2/K", "W/m^2/K^2", "W/m^2/K^3"
    rows = [
        ("quadratic-h0", "h₀ of the fitted parabola", 0, full, h, 0.005),
        ("quadratic-h1", "h₁ of the fitted parabola", 1, full, t, 0.005),
        ("quadratic-h2", "h₂ of the fitted parabola", 2, full, t2, 0.000005),
        ("no-linear-h0", "h₀ of the fitted parabola, h₁ held at 0", 0, even, h, 0.005),
        ("no-linear-h2", "h₂ of the fitted parabola, h₁ held at 0", 2, even, t2, 0.000005),
    ]
    return [
        *(
            Claim.checked(
                f"fit-{id}", statement, FIT, printed.coefficients[k], fit.coefficients[k],
                unit, tolerance, optimum,
            )
            for id, statement, k, fit, unit, tolerance in rows
        ),
        Claim.checked(
            "fit-r2-printed", "R² of the printed coefficients", FIT,
            printed.r_squared, printed_r_squared(printed), "1", 0.00005,
            "on the printed points; with h₁ = 0 the best is "
            f"{even.r_squared:.5f} at ({even.coefficients[0]:.3f}, 0, {even.coefficients[2]:.7f})",
        ),
        Claim.checked(
            "fit-r2-best", "R² of the best parabola", FIT,
            printed.r_squared, full.r_squared, "1", 0.00005,
            "no parabola has a higher R² on the printed points",
        ),
        Claim.reported(
            "fit-r2-line", "R² of a straight line", FIT, line.r_squared, "1",
            f"h = {line.coefficients[0]:.3f} + {line.coefficients[1]:.5f} T; adjusted R² "
            f"{line.adjusted:.3f} against {even.adjusted:.3f} with h₁ = 0 and "
            f"{full.adjusted:.3f} of the parabola: four points support no curvature",
        ),
    ]  # fmt: skip


def refitted(printed: Printed) -> PolynomialCooling:
    """The film coefficient fitted here with h₁ = 0."""
    h0, h1, h2 = no_linear(printed).coefficients
    return PolynomialCooling(h0=h0, h1=h1, h2=h2)


COOLINGS = {
    "polynomial": bench.polynomial,
    "refitted": refitted,
    "constant": bench.mean_constant,
}


def steady_errors(cooling: str, printed: Printed) -> list[float]:
    """Simulated less printed steady temperatures with one of `COOLINGS` [K]."""
    model = COOLINGS[cooling](printed)
    return [
        bench.steady_temperature(model, bench.heating_power(step, printed)) - step.temperature
        for step in printed.steps
    ]


def _steady(printed: Printed) -> list[Claim]:
    errors = steady_errors("polynomial", printed)
    mean = steady_errors("constant", printed)
    listed = ", ".join(f"{error:+.1f}" for error in mean)
    return [
        *(
            Claim.checked(
                f"steady-{step.voltage:.1f}V", f"steady temperature at {step.voltage:.1f} V",
                TABLE_2, step.temperature, step.temperature + error, "degC", ALLOWED,
                "simulated with the printed h(T) and the power behind the row; h(T) was fitted "
                "to these rows, so it is the fit and the simulator that are checked",
            )
            for step, error in zip(printed.steps, errors, strict=True)
        ),
        Claim.reported(
            "steady-constant-h", "largest error of a steady temperature with the mean h", TABLE_2,
            max(mean, key=abs), "K",
            f"{listed} K at the four steps: a constant h cannot hold both ends, which is the "
            "paper's case for h(T), made without a number",
        ),
    ]  # fmt: skip


def _ambient(printed: Printed) -> list[Claim]:
    films = films_at_ambient(OTHER_AMBIENT, printed)
    listed = ", ".join(f"{h:.1f}" for h in films)
    here = straight(printed).coefficients[1]
    there = fit_film(printed.temperatures, films, terms=(0, 1)).coefficients[1]
    return [
        Claim.reported(
            "ambient-sensitivity", f"mean slope of h(T) if the ambient was {OTHER_AMBIENT:g} °C",
            TABLE_2, there, "W/m^2/K^2",
            f"h would be {listed} W/(m² K), the slope at {printed.ambient:g} °C being "
            f"{here:.3f}: the rise of h with T rests on an ambient temperature known to 1 K",
        )
    ]  # fmt: skip
