"""What steady states say about a film coefficient, and what they leave open, in words.

Three questions are put to the points, each with an interval of the level asked for:

- does h bend? The square beside a linear term, at the given ambient and with the ambient free;
- does h rise or fall? The slope of a straight line, in the same two ways;
- is the ambient temperature in the points? Its interval with a straight line for h, or with a
  parabola if h bends.

An answer is yes only if it does not rest on the given ambient. The ways of fitting are those
of `martensite.characterise.film_coefficient` and `martensite.characterise.film_ambient`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from martensite.base.confidence import LEVEL
from martensite.characterise.film_ambient import FreeAmbient, fit_free_ambient
from martensite.characterise.film_coefficient import FORMS, FilmFit, fit_film
from martensite.characterise.film_points import FilmPoints
from martensite.characterise.film_sensitivity import (
    AtAmbient,
    Confounding,
    film_per_kelvin,
    find_confounding,
    find_level_ambient,
    shift_ambients,
    slope_per_kelvin,
)
from martensite.characterise.film_verdicts import FilmVerdict, judge_ambient, judge_curvature, judge_slope


@dataclass(frozen=True)
class AmbientReport:
    """What the film coefficient owes to the ambient temperature."""

    shifts: tuple[AtAmbient, ...]
    """Points and lines at ambient temperatures near the given one."""
    per_kelvin: tuple[float, ...]
    """dh/dT_a of every point [W/(m² K²)]."""
    slope_per_kelvin: float
    """Derivative of the slope of the straight line with respect to T_a [W/(m² K³)]."""
    without_slope: float
    """Ambient temperature at which the straight line is level [°C]; NaN if there is none."""
    confounding: Confounding
    free: dict[str, FreeAmbient]
    """Fits of h together with the ambient, by form."""

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """All numbers by name, for JSON."""
        return {
            "shifts": [shift.to_dict(level) for shift in self.shifts],
            "dh_dambient": list(self.per_kelvin),
            "dslope_dambient": self.slope_per_kelvin,
            "ambient_without_slope_degC": self.without_slope,
            "correlation_of_slope_and_ambient": self.confounding.correlation,
            "condition_number": self.confounding.condition,
            "free_ambient": {form: fit.to_dict(level) for form, fit in self.free.items()},
        }


@dataclass(frozen=True)
class FilmReport:
    """Fits of a film coefficient, its dependence on the ambient, and the verdicts."""

    points: FilmPoints
    fits: dict[str, FilmFit]
    """Fits by the name of their form, of the forms that the points determine."""
    ambient: AmbientReport | None
    """None if the ambient temperature is not known."""
    verdicts: tuple[FilmVerdict, ...]
    level: float = LEVEL

    def __getitem__(self, about: str) -> FilmVerdict:
        """The verdict on `curvature`, `slope` or `ambient`."""
        return next(verdict for verdict in self.verdicts if verdict.about == about)

    def to_dict(self) -> dict[str, Any]:
        """All numbers and sentences by name, for JSON."""
        return {
            "points": self.points.to_dict(),
            "level": self.level,
            "fits": {form: fit.to_dict(self.level) for form, fit in self.fits.items()},
            "ambient": None if self.ambient is None else self.ambient.to_dict(self.level),
            "verdicts": [verdict.to_dict() for verdict in self.verdicts],
        }


def judge_film(points: FilmPoints, level: float = LEVEL) -> FilmReport:
    """Fit every form to steady states, and say which of them the points support.

    Raises:
        DataError: there are not two different temperatures, or all film coefficients are equal.
    """
    different = len(set(points.temperatures_degC))
    forms = {form: terms for form, terms in FORMS.items() if len(terms) <= max(different, 2)}
    fits = {f: fit_film(points.temperatures_degC, points.h, terms) for f, terms in forms.items()}
    report = None if points.ambient_degC is None else _report_ambient(points)
    free = {} if report is None else report.free
    bend = judge_curvature(points, fits, free, level)
    without = float("nan") if report is None else report.without_slope
    verdicts = [bend, judge_slope(points, fits, free, without, bend.supported, level)]
    if report is not None:
        form = "quadratic" if bend.supported else "linear"
        verdicts.append(judge_ambient(free, form, report.confounding, level))
    return FilmReport(points, fits, report, tuple(verdicts), level)


def _report_ambient(points: FilmPoints) -> AmbientReport:
    found = {form: fit_free_ambient(points, FORMS[form][-1]) for form in list(FORMS)[:3]}
    return AmbientReport(
        shifts=tuple(shift_ambients(points)),
        per_kelvin=film_per_kelvin(points),
        slope_per_kelvin=slope_per_kelvin(points),
        without_slope=find_level_ambient(points),
        confounding=find_confounding(points),
        free={form: fit for form, fit in found.items() if fit is not None},
    )
