"""`fit h`: fit the film coefficient of a wire to steady states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from martensite.base.errors import DataError, InputError, UnknownNameError
from martensite.cli.commands.fit import fit
from martensite.cli.options import Text, read_quantity, spread_options
from martensite.cli.outputs import AnswerOptions

if TYPE_CHECKING:
    from martensite.characterise.film_coefficient import FilmFit, FilmPoints
    from martensite.characterise.film_report import FilmReport
    from martensite.physics.thermal.base import AbstractCooling
    from martensite.signals.records import Record

ALL = "all"
ZERO = 273.15
"""0 °C [K]."""
FILM = "W/m^2/K"
UNITS = {"diameter": "m", "length": "m", "ambient": "K", "resistance": "ohm"}


@dataclass(frozen=True)
class HeatedWire:
    """Wire data of the command line; None for a missing value."""

    diameter: Annotated[Text, Option(help='Wire diameter, e.g. "0.381 mm".')] = None
    length: Annotated[Text, Option(help='Wire length, e.g. "273 mm".')] = None
    ambient: Annotated[Text, Option(help='Ambient temperature, e.g. "38.5 degC".')] = None
    resistance: Annotated[Text, Option(help='Resistance across the measured voltage, e.g. "2.7 ohm".')] = None

    def read(self, name: str) -> float | None:
        """Return a value in SI."""
        return read_quantity(name, getattr(self, name), UNITS[name])

    def refuse(self, names: Sequence[str], why: str) -> None:
        """Raise `InputError` if an option without effect is given."""
        for name in names:
            if getattr(self, name) is not None:
                raise InputError(f"Option `--{name}` has no effect, since {why}.")

    def need(self, name: str, why: str) -> float:
        """Return a value in SI; raise `InputError` if it is missing."""
        value = self.read(name)
        if value is None:
            raise InputError(f"Option `--{name}` is needed, since {why}.")
        return value


@fit.command("h")
@spread_options
def film(
    table: Annotated[Path, Argument(metavar="TABLE", help="Table of steady states, one per row (columns: see above).")],
    wire: HeatedWire,
    answer: AnswerOptions,
    form: Annotated[str, Option(help="Form of h(T): all, constant, linear, quadratic, or h1=0.")] = ALL,
    out: Annotated[Path | None, Option(help="Heat-loss model to write: .toml; needs a single --form.")] = None,
) -> None:
    """Fit a film coefficient h(T) to steady states.

    TABLE holds steady states of a heated wire. It needs a column `temperature` and one of: `h [W/m^2/K]`; `power`;
    `voltage` with `current`; `voltage` with `resistance`, or with --resistance. All but `h` need --diameter,
    --length and --ambient.
    """
    _check_form(form, out)
    outputs = answer.check_files(out, ".toml")
    points, origin = read_points(table, wire)
    from martensite.characterise.film_report import judge_film
    from martensite.show.figures.laboratory import plot_film
    from martensite.show.summaries.laboratory import summarise_film

    report = judge_film(points)
    forms = _choose_forms(report, form)
    title = f"Film coefficient from {table.name}"
    outputs.answer(
        summarise_film(report, forms, origin),
        answer.json,
        lambda: write_cooling(report, form, table.name),
        lambda: plot_film(report, forms, title),
    )


def _check_form(form: str, out: Path | None) -> None:
    from martensite.characterise.film_coefficient import FORMS

    if form not in (ALL, *FORMS):
        raise UnknownNameError("form of h(T)", form, (ALL, *FORMS))
    if out is not None and form == ALL:
        listed = ", ".join(f"`{name}`" for name in FORMS)
        raise InputError(f"Option `--out` writes one form of h(T): give --form as one of {listed}.")


def _choose_forms(report: FilmReport, form: str) -> list[str]:
    if form == ALL:
        return list(report.fits)
    if form not in report.fits:
        raise InputError(
            f"{len(report.points)} points do not determine the form `{form}`; "
            "measure at more temperatures, or fit another form."
        )
    return [form]


def read_points(table: Path, wire: HeatedWire) -> tuple[FilmPoints, str]:
    """Return the points of a table and the origin of their film coefficients."""
    from martensite.characterise.film_coefficient import FilmPoints, compute_film_points
    from martensite.logs.reader import read_complete

    record = read_complete(table, 1.0)
    at = tuple(_to_celsius(kelvin) for kelvin in record["temperature"].tolist())
    if "h" in record.columns:
        if record.units["h"] != FILM:
            raise DataError(f"{table}: column `h` must be in W/(m² K); write `h [{FILM}]`.")
        wire.refuse(("diameter", "length", "resistance"), "the table has a column `h`")
        ambient = wire.read("ambient")
        given = None if ambient is None else _to_celsius(ambient)
        return FilmPoints(at, tuple(record["h"].tolist()), given), "column `h`"
    powers, origin = _read_powers(record, wire)
    sizes = {
        name: wire.need(name, "h = P/[π d l (T - T_a)] is to be found") for name in ("diameter", "length", "ambient")
    }
    ambient = _to_celsius(sizes.pop("ambient"))
    return compute_film_points(at, powers, **sizes, ambient_degC=ambient), origin


def _to_celsius(kelvin: float) -> float:
    """Return a temperature [°C] without the rounding error of the conversion to kelvin and back."""
    return round(kelvin - ZERO, 9)


def _read_powers(record: Record, wire: HeatedWire) -> tuple[list[float], str]:
    """Return heating powers [W] and the columns behind them."""
    from martensite.characterise.film_coefficient import powers_from_voltage

    has = {name: column.tolist() for name, column in record.columns.items()}
    if "power" in has:
        wire.refuse(("resistance",), "the table has a column `power`")
        return has["power"], "column `power`"
    if "voltage" not in has:
        raise DataError(
            f"Record `{record.name}` needs a column `h`, `power` or `voltage` beside "
            f"`temperature`, but has only {', '.join(f'`{name}`' for name in record.units)}."
        )
    if "current" in has:
        wire.refuse(("resistance",), "the table has a column `current`")
        pairs = zip(has["voltage"], has["current"], strict=True)
        return [volts * amperes for volts, amperes in pairs], "columns `voltage` and `current`"
    if "resistance" in has:
        wire.refuse(("resistance",), "the table has a column `resistance`")
        powers = powers_from_voltage(has["voltage"], has["resistance"])
        return powers, "columns `voltage` and `resistance`"
    ohms = wire.need("resistance", "the table has voltages but neither currents nor resistances")
    return powers_from_voltage(has["voltage"], ohms), f"column `voltage` and {ohms:g} ohm"


def write_cooling(report: FilmReport, form: str, table: str) -> str:
    """Return the surroundings with one fitted form, as TOML with its source."""
    from martensite.show.summaries.laboratory import FILM_UNITS, write_coefficient

    fit = report.fits[form]
    _make_cooling(fit)
    numbers = [(f"h{k}", fit.coefficients[k], FILM_UNITS[k]) for k in fit.terms]
    listed = ", ".join(f"h{k} = {write_coefficient(fit, k, report.level)}" for k in fit.terms)
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


def _make_cooling(fit: FilmFit) -> AbstractCooling:
    from martensite.physics.thermal.films import ConstantCooling, PolynomialCooling

    if fit.terms == (0,):
        return ConstantCooling(h=fit.coefficients[0])
    h0, h1, h2 = (*fit.coefficients, 0.0)[:3]
    return PolynomialCooling(h0=h0, h1=h1, h2=h2)
