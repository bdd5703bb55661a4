"""The film coefficient of a wire: fits, their sensitivity to the ambient, and the verdicts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.characterise.film_coefficient import FilmFit
from martensite.characterise.film_report import FilmReport

FILM = "W/m^2/K"
UNITS = (FILM, "W/m^2/K^2", "W/m^2/K^3")


def summarise_film(report: FilmReport, forms: Sequence[str], origin: str) -> Summary:
    """Everything about fits of a film coefficient.

    Args:
        report: the fits.
        forms: those to show.
        origin: where the points come from.
    """
    title = f"h(T) from {len(report.points)} points, {origin}"
    return Summary(title, list(_describe_film(report, forms)), {"origin": origin} | report.to_dict())


def _describe_film(report: FilmReport, forms: Sequence[str]) -> Iterator[Block]:
    yield DataTable(
        ("form", *(f"h{k} [{unit}]" for k, unit in enumerate(UNITS)), "R²", "adjusted", "AICc"),
        [_form_row(form, report.fits[form], report.level) for form in forms],
        right=range(1, 7),
    )
    yield Sentence(f"T in degC; ± half the {100.0 * report.level:g} % interval.")
    yield _tabulate_ambients(report)
    for verdict in report.verdicts:
        yield Sentence(verdict.sentence, "good" if verdict.supported else "caution")


def _tabulate_ambients(report: FilmReport) -> Block:
    if report.ambient is None:
        return Sentence("The ambient temperature behind h is not given: what h owes to it is not tested.")
    rows = [
        (
            f"{shift.points.ambient:g}",
            f"{shift.points.ambient - report.points.ambient:+g}",
            ", ".join(f"{h:.1f}" for h in shift.points.h),
            write_coefficient(shift.line, 1, report.level),
            f"{shift.line.r_squared:.4f}",
        )
        for shift in report.ambient.shifts
    ]
    head = ("ambient [degC]", "shift [K]", f"h [{FILM}]", f"slope [{UNITS[1]}]", "R²")
    return DataTable(head, rows, right=range(5))


def _form_row(form: str, fit: FilmFit, level: float) -> tuple[str, ...]:
    cells = (write_coefficient(fit, k, level) if k in fit.terms else "0" for k in range(3))
    scores = (fit.r_squared, 5), (fit.adjusted, 3), (fit.aicc, 2)
    # a score that there are too few points for is left out
    texts = (f"{number:.{d}f}" if math.isfinite(number) else "" for number, d in scores)
    return form, *cells, *texts


def write_coefficient(fit: FilmFit, term: int, level: float) -> str:
    """A coefficient with half its interval."""
    value = fit.coefficients[term]
    low, high = fit.interval(term, level)
    half = 0.5 * (high - low)
    return f"{value:.5g} ± {half:.2g}" if math.isfinite(half) else f"{value:.5g}"
