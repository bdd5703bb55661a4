"""`fit h`: reading the table, what is printed, and the heat-loss model written."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

from martensite.base.errors import DataError, InputError
from martensite.cli.options import quantity

if TYPE_CHECKING:
    from martensite.characterise.film_coefficient import FilmFit
    from martensite.characterise.film_points import FilmPoints
    from martensite.characterise.film_report import FilmReport
    from martensite.physics.thermal.base import AbstractCooling
    from martensite.signals.records import Record

ZERO = 273.15
"""0 °C [K]."""
FILM = "W/m^2/K"
UNITS = (FILM, "W/m^2/K^2", "W/m^2/K^3")


@dataclass(frozen=True)
class Wire:
    """What the command line says of the wire, in SI; None for what it does not say."""

    diameter: float | None
    length: float | None
    ambient: float | None
    resistance: float | None

    @classmethod
    def read(
        cls, diameter: str | None, length: str | None, ambient: str | None, resistance: str | None
    ) -> Wire:
        """Read the options.

        Raises:
            UnitError: one of them is no quantity, or of another dimension.
        """
        given = (
            ("diameter", diameter, "m"), ("length", length, "m"),
            ("ambient", ambient, "K"), ("resistance", resistance, "ohm"),
        )  # fmt: skip
        return cls(*(None if t is None else quantity(name, t, unit) for name, t, unit in given))

    def refuse(self, names: Sequence[str], why: str) -> None:
        """Raise `InputError` if an option is given that has no effect."""
        for name in names:
            if getattr(self, name) is not None:
                raise InputError(f"Option `--{name}` has no effect, since {why}.")

    def need(self, name: str, why: str) -> float:
        """An option in SI; raise `InputError` if it is missing."""
        found = getattr(self, name)
        if found is None:
            raise InputError(f"Option `--{name}` is needed, since {why}.")
        return found


def read_points(table: Path, wire: Wire) -> tuple[FilmPoints, str]:
    """The points of a table, and where their film coefficients come from.

    Raises:
        DataError: the table has no temperatures, or nothing that h follows from.
        InputError: an option is missing, or has no effect.
    """
    from martensite.characterise.film_points import FilmPoints, points_from_power
    from martensite.scenario.tables import read_table

    record = read_table(table, interval=1.0)
    at = tuple(_celsius(kelvin) for kelvin in record["temperature"])
    if "h" in record.columns:
        if record.units["h"] != FILM:
            raise DataError(f"{table}: column `h` must be in W/(m² K); write `h [{FILM}]`.")
        wire.refuse(("diameter", "length", "resistance"), "the table has a column `h`")
        given = None if wire.ambient is None else _celsius(wire.ambient)
        return FilmPoints(at, tuple(record["h"]), given), "column `h`"
    powers, origin = _powers(record, wire)
    sizes = {
        name: wire.need(name, "h = P/[π d l (T - T_a)] is to be found")
        for name in ("diameter", "length", "ambient")
    }
    ambient = _celsius(sizes.pop("ambient"))
    return points_from_power(at, powers, **sizes, ambient_degC=ambient), origin


def _celsius(kelvin: float) -> float:
    """A temperature [°C] without the rounding error of its way through kelvin."""
    return round(kelvin - ZERO, 9)


def _powers(record: Record, wire: Wire) -> tuple[list[float], str]:
    """Heating powers [W], and what they were computed from."""
    from martensite.characterise.film_points import powers_from_voltage

    has = record.columns
    if "power" in has:
        wire.refuse(("resistance",), "the table has a column `power`")
        return record["power"], "column `power`"
    if "voltage" not in has:
        raise DataError(
            f"Record `{record.name}` needs a column `h`, `power` or `voltage` beside "
            f"`temperature`, but has only {', '.join(f'`{name}`' for name in record.units)}."
        )
    if "current" in has:
        wire.refuse(("resistance",), "the table has a column `current`")
        pairs = zip(record["voltage"], record["current"], strict=True)
        return [volts * amperes for volts, amperes in pairs], "columns `voltage` and `current`"
    if "resistance" in has:
        wire.refuse(("resistance",), "the table has a column `resistance`")
        powers = powers_from_voltage(record["voltage"], record["resistance"])
        return powers, "columns `voltage` and `resistance`"
    ohms = wire.need("resistance", "the table has voltages but neither currents nor resistances")
    return powers_from_voltage(record["voltage"], ohms), f"column `voltage` and {ohms:g} ohm"


# ---------------------------------------------------------------- printing


def print_report(
    report: FilmReport, forms: Sequence[str], origin: str, written: Sequence[Path]
) -> None:
    """Print fits, the sensitivity to the ambient temperature, and the verdicts."""
    from martensite.cli import show

    share = f"{100.0 * report.level:g} %"
    show.text(f"h(T) from {len(report.points)} points, {origin}", "bold")
    show.table(
        ("form", *(f"h{k} [{unit}]" for k, unit in enumerate(UNITS)), "R²", "adjusted", "AICc"),
        [_row(form, report.fits[form], report.level) for form in forms],
        right="R²,adjusted,AICc",
    )
    show.text(f"T in degC; ± half the {share} interval.")
    if report.ambient is not None:
        rows = [
            (
                f"{shift.points.ambient:g}", f"{shift.points.ambient - report.points.ambient:+g}",
                ", ".join(f"{h:.1f}" for h in shift.points.h),
                _with_interval(shift.line, 1, report.level), f"{shift.line.r_squared:.4f}",
            )
            for shift in report.ambient.shifts
        ]  # fmt: skip
        columns = ("ambient [degC]", "shift [K]", f"h [{FILM}]", f"slope [{UNITS[1]}]", "R²")
        show.table(columns, rows, right="ambient [degC],shift [K],R²")
    else:
        show.text("The ambient temperature behind h is not given: what h owes to it is not tested.")
    for verdict in report.verdicts:
        show.text(verdict.sentence, "green" if verdict.supported else "yellow")
    for path in written:
        show.text(f"wrote {path}")


def _row(form: str, fit: FilmFit, level: float) -> tuple[str, ...]:
    cells = (_with_interval(fit, k, level) if k in fit.terms else "0" for k in range(3))
    scores = (_score(fit.r_squared, 5), _score(fit.adjusted, 3), _score(fit.aicc, 2))
    return (form, *cells, *scores)


def _score(number: float, digits: int) -> str:
    """A score; empty where there are too few points for it."""
    return f"{number:.{digits}f}" if math.isfinite(number) else ""


def _with_interval(fit: FilmFit, term: int, level: float) -> str:
    value = fit.coefficients[term]
    half = 0.5 * (fit.interval(term, level)[1] - fit.interval(term, level)[0])
    return f"{value:.5g} ± {half:.2g}" if math.isfinite(half) else f"{value:.5g}"


# ---------------------------------------------------------------- the model written


def snippet(report: FilmReport, form: str, table: str) -> str:
    """The surroundings of a scenario with one fitted form, as TOML with its provenance.

    Raises:
        ParameterError: a coefficient is outside what the heat-loss model allows.
    """
    fit = report.fits[form]
    _model(fit)
    numbers = [(f"h{k}", fit.coefficients[k], UNITS[k]) for k in fit.terms]
    listed = ", ".join(f"h{k} = {_with_interval(fit, k, report.level)}" for k in fit.terms)
    origin = (
        f"Film coefficient fitted to {len(report.points)} points of {table}, form {form}, T in "
        f"degC: {listed} ({100 * report.level:g} %); R² {fit.r_squared:.5f}."
    )
    sentences = (origin, *(verdict.sentence for verdict in report.verdicts))
    comments = [line for sentence in sentences for line in wrap(sentence, 97)]
    lines = [*(f"# {line}" for line in comments), "[environment]"]
    if report.points.ambient_degC is not None:
        lines.append(f'temperature = "{report.points.ambient:.10g} degC"')
    kind = "constant" if form == "constant" else "polynomial"
    named = [("h", *numbers[0][1:])] if kind == "constant" else numbers
    entries = ", ".join(f'{name} = "{value:.8g} {unit}"' for name, value, unit in named)
    return "\n".join([*lines, f'cooling = {{ kind = "{kind}", {entries} }}', ""])


def _model(fit: FilmFit) -> AbstractCooling:
    """The heat-loss model with the fitted numbers; refuses what it does not allow."""
    from martensite.physics.thermal.constant import ConstantCooling
    from martensite.physics.thermal.polynomial import PolynomialCooling

    if fit.terms == (0,):
        return ConstantCooling(h=fit.coefficients[0])
    h0, h1, h2 = (*fit.coefficients, 0.0)[:3]
    return PolynomialCooling(h0=h0, h1=h1, h2=h2)
