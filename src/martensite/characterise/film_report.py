"""Tests of a film coefficient from steady states, as verdicts with numbers.

Three questions have intervals of the requested level:

- Does h bend? Test of the quadratic term, at the given ambient and with a free ambient.
- Does h rise or fall? Test of the slope of a straight line, in the same two ways.
- Do the points determine the ambient temperature? Its interval with a straight line for h, or a parabola if h bends.

An answer is yes only if it does not depend on the given ambient. The fits are in
`martensite.characterise.film_coefficient` and `martensite.characterise.film_ambient`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

from martensite.base.confidence import LEVEL, Interval, interval_contains
from martensite.characterise.film_ambient import (
    AtAmbient,
    Confounding,
    FreeAmbient,
    film_per_kelvin,
    find_confounding,
    find_level_ambient,
    fit_free_ambient,
    shift_ambients,
    slope_per_kelvin,
)
from martensite.characterise.film_coefficient import ABSOLUTE_ZERO, FORMS, FilmFit, FilmPoints, fit_film_points

UNITS = ("W/m²/K", "W/m²/K²", "W/m²/K³")
"""Units of h₀, h₁, h₂."""
NOT_GIVEN = "if the ambient temperature behind h, which is not given, is right"
_DIGITS = "₀₁₂"


@dataclass(frozen=True)
class FilmVerdict:
    """Verdict on one question about the points."""

    about: str
    """`curvature`, `slope` or `ambient`."""
    supported: bool
    """True if the points alone support it."""
    sentence: str
    """Verdict with its values."""

    def to_dict(self) -> dict[str, Any]:
        """Return all fields by name, for JSON."""
        return asdict(self)


def judge_curvature(
    points: FilmPoints, fits: Mapping[str, FilmFit], free: Mapping[str, FreeAmbient], level: float
) -> FilmVerdict:
    """Return the test of the quadratic term."""
    verdict = partial(FilmVerdict, "curvature")
    fit = fits.get("quadratic")
    if fit is None or not fit.linear.freedom:
        return verdict(False, "Curvature is not tested: that takes at least four points at three temperatures.")
    given, line = fit.interval(2, level), fits["linear"]
    number = f"beside a linear term {_word_coefficient(2, fit.coefficients[2], given, level)}"
    change = "falls" if fit.adjusted < line.adjusted else "rises"
    compared = f"adjusted R² {change} from {line.adjusted:.3f} to {fit.adjusted:.3f}"
    if interval_contains(given):
        return verdict(False, f"Curvature is not supported: {number}, includes 0; {compared}.")
    beside = free.get("quadratic")
    at = _word_ambient(points)
    if points.ambient_degC is None:
        return verdict(False, f"Curvature is supported only {NOT_GIVEN}: {number}; {compared}.")
    if beside is not None and interval_contains(interval := beside.leading_interval(level)):
        return verdict(
            False,
            f"Curvature rests on the ambient temperature: {at}{number}, {compared}, but with the "
            f"ambient free it is {_word_coefficient(2, beside.leading, interval, level)}, and "
            "includes 0.",
        )
    return verdict(True, f"Curvature is supported: {at}{number}; {compared}.")


def judge_slope(
    points: FilmPoints,
    fits: Mapping[str, FilmFit],
    free: Mapping[str, FreeAmbient],
    without: float,
    bent: bool,
    level: float,
) -> FilmVerdict:
    """Return the test of a film coefficient that rises or falls with temperature."""
    verdict = partial(FilmVerdict, "slope")
    line = fits["linear"]
    given, at = line.interval(1, level), _word_ambient(points)
    number = _word_coefficient(1, line.coefficients[1], given, level)
    if bent:
        return verdict(True, f"h depends on temperature, since it bends: {at}mean {number}.")
    if not line.linear.freedom:
        return verdict(False, "A slope of h is not tested: that takes three points.")
    if interval_contains(given):
        return verdict(False, f"A slope of h is not supported: {at}{number}, includes 0.")
    if points.ambient_degC is None:
        return verdict(False, f"A slope of h is supported only {NOT_GIVEN}: {number}.")
    beside = free.get("linear")
    against = "" if beside is None else _contradict_slope(beside, line.coefficients[1], level)
    if against:
        return verdict(
            False,
            f"The slope of h rests on the ambient temperature: {at}{number}"
            f"{_word_level(points, without)}; with the ambient free it is {against}.",
        )
    return verdict(True, f"A slope of h is supported: {at}{number}.")


def judge_ambient(free: Mapping[str, FreeAmbient], form: str, confounding: Confounding, level: float) -> FilmVerdict:
    """Return the test whether the points determine the ambient temperature."""
    verdict = partial(FilmVerdict, "ambient")
    fit, beside = free.get(form), "a slope" if form == "linear" else "a bend"
    if fit is None or not fit.flux.freedom:
        return verdict(False, "The ambient temperature is not tested: that takes at least four points.")
    span = _word_span(fit.ambient_interval(level), fit.coldest)
    share = f"{100.0 * level:g} %"
    if fit.is_bounded(level):
        return verdict(
            True,
            f"The points determine the ambient temperature beside {beside} of h: "
            f"{fit.ambient:.1f} degC, {share} interval {span}.",
        )
    best = f"best {fit.ambient:.1f} degC, " if math.isfinite(fit.ambient) else "none fits best, "
    constant = free["constant"]
    return verdict(
        False,
        f"The points do not determine the ambient temperature beside {beside} of h: {best}{share} "
        f"interval {span} (correlation {confounding.correlation:.3f}, condition number "
        f"{confounding.condition:.0f}). With a constant h it would be {constant.ambient:.1f} degC, "
        f"{_word_span(constant.ambient_interval(level), constant.coldest)}.",
    )


def _contradict_slope(free: FreeAmbient, given: float, level: float) -> str:
    """Describe the contradiction between a slope and a fit with free ambient; empty if they agree."""
    interval = free.leading_interval(level)
    number = _word_coefficient(1, free.leading, interval, level)
    if interval_contains(interval):
        return f"{number}, and includes 0"
    if free.leading * given < 0.0:
        return f"{number}, of the other sign"
    return "" if math.isfinite(free.ambient) else f"{number}, but for no ambient below the points"


def _word_coefficient(term: int, value: float, interval: Interval, level: float = LEVEL) -> str:
    low, high = interval
    share = f"{100.0 * level:g} %"
    between = f"{share} interval unbounded" if not math.isfinite(low) else f"{share} interval {low:.3g} to {high:.3g}"
    return f"h{_DIGITS[term]} = {value:.3g} {UNITS[term]}, {between}"


def _word_ambient(points: FilmPoints) -> str:
    return "" if points.ambient_degC is None else f"at {points.ambient:g} degC "


def _word_level(points: FilmPoints, without: float) -> str:
    if not math.isfinite(without):
        return ""
    return f", but zero for an ambient of {without:.1f} degC ({without - points.ambient:+.1f} K)"


def _word_span(interval: Interval, coldest: float) -> str:
    low, high = interval
    if low <= ABSOLUTE_ZERO:
        return "without bounds" if high >= coldest else f"anything below {high:.1f} degC"
    return f"{low:.1f} to {high:.1f} degC"


@dataclass(frozen=True)
class AmbientReport:
    """Effect of the ambient temperature on the film coefficient."""

    shifts: tuple[AtAmbient, ...]
    """Points and lines at ambient temperatures near the given one."""
    per_kelvin: tuple[float, ...]
    """dh/dT_a of every point [W/(m² K²)]."""
    slope_per_kelvin: float
    """Derivative of the slope of the straight line with respect to T_a [W/(m² K³)]."""
    without_slope: float
    """Ambient temperature at which the straight line is level [°C]; NaN if it does not exist."""
    confounding: Confounding
    free: dict[str, FreeAmbient]
    """Fits of h together with the ambient, by form."""

    def to_dict(self, level: float = LEVEL) -> dict[str, Any]:
        """Return all numbers by name, for JSON."""
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
    """Fits by name of their form, for the forms that the points determine."""
    ambient: AmbientReport | None
    """None if the ambient temperature is unknown."""
    verdicts: tuple[FilmVerdict, ...]
    level: float = LEVEL

    def __getitem__(self, about: str) -> FilmVerdict:
        """Return the verdict on `curvature`, `slope` or `ambient`."""
        return next(verdict for verdict in self.verdicts if verdict.about == about)

    def to_dict(self) -> dict[str, Any]:
        """Return all values and sentences by name, for JSON."""
        return {
            "points": self.points.to_dict(),
            "level": self.level,
            "fits": {form: fit.to_dict(self.level) for form, fit in self.fits.items()},
            "ambient": None if self.ambient is None else self.ambient.to_dict(self.level),
            "verdicts": [verdict.to_dict() for verdict in self.verdicts],
        }


def judge_film(points: FilmPoints, level: float = LEVEL) -> FilmReport:
    """Fit every form to steady states, and test which forms the points support.

    Raises:
        DataError: there are not two different temperatures, or all film coefficients are equal.
    """
    different = len(set(points.temperatures_degC))
    forms = {form: terms for form, terms in FORMS.items() if len(terms) <= max(different, 2)}
    fits = {form: fit_film_points(points, terms) for form, terms in forms.items()}
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
    fits = {form: fit_free_ambient(points, FORMS[form][-1]) for form in list(FORMS)[:3]}
    return AmbientReport(
        shifts=tuple(shift_ambients(points)),
        per_kelvin=film_per_kelvin(points),
        slope_per_kelvin=slope_per_kelvin(points),
        without_slope=find_level_ambient(points),
        confounding=find_confounding(points),
        free={form: fit for form, fit in fits.items() if fit is not None},
    )
