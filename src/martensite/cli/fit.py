"""`fit`: numbers of a model from measurements, with what the measurements leave open."""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer.core import TyperGroup

from martensite.base.errors import InputError, UnknownNameError
from martensite.cli.app import app
from martensite.cli.options import Figure, Force, Json

if TYPE_CHECKING:
    from martensite.characterise.film_report import FilmReport

LOGS = "logs"
"""What is meant where no command is named."""


class Fits(TyperGroup):
    """Commands, and `logs` where the first word is none of them."""

    def parse_args(self, ctx: typer.Context, args: list[str]) -> list[str]:
        """Name `logs` where it is meant."""
        return super().parse_args(ctx, self.worded(args))

    def worded(self, args: list[str]) -> list[str]:
        """The words of a call with its command first."""
        if not args or args[0] in ("-h", "--help") or self._names(args[0]):
            return args
        return [LOGS, *args]

    def _names(self, word: str) -> bool:
        """Whether a word is a command, or a misspelt one that is no file either."""
        if word in self.commands:
            return True
        near = get_close_matches(word, self.commands, n=1, cutoff=0.7)
        return bool(near) and not Path(word).exists()


fit = typer.Typer(
    cls=Fits,
    short_help="Fit the numbers of a scenario to measured logs.",
    help="Fit numbers of a model to measurements: `martensite fit LOG... --scenario S --free ...` "
    "(or fit FILE.toml), or one of the commands below.",
    no_args_is_help=True,
)
app.add_typer(fit, name="fit")

ALL = "all"


@fit.command("h")
def film(
    table: Annotated[
        Path, typer.Argument(metavar="TABLE", help="Steady states, one per row (see below).")
    ],
    diameter: Annotated[
        str | None, typer.Option(help='Diameter of the wire, e.g. "0.381 mm".')
    ] = None,
    length: Annotated[str | None, typer.Option(help='Length of the wire, e.g. "273 mm".')] = None,
    ambient: Annotated[
        str | None, typer.Option(help='Ambient temperature, e.g. "38.5 degC".')
    ] = None,
    resistance: Annotated[
        str | None, typer.Option(help='Resistance that the voltage heats, e.g. "2.7 ohm".')
    ] = None,
    form: Annotated[str, typer.Option(help="all, constant, linear, quadratic, or h1=0.")] = ALL,
    out: Annotated[
        Path | None, typer.Option(help="Heat-loss model to write: .toml; takes one --form.")
    ] = None,
    figure: Figure = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Fit a film coefficient h(T) to steady states, and judge the fit.

    TABLE holds steady states of a heated wire. It needs a column `temperature` and one of:
    `h [W/m^2/K]`; `power`; `voltage` with `current`; `voltage` with `resistance`, or with
    --resistance. All but `h` take --diameter, --length and --ambient.
    """
    from martensite.cli.fit_film import Wire, print_report, read_points, snippet
    from martensite.cli.outputs import Outputs, parts

    _check_form(form, out)
    outputs = Outputs(out, figure).check(force, data=(".toml",))
    points, origin = read_points(table, Wire.read(diameter, length, ambient, resistance))
    from martensite.characterise.film_report import judge_film

    report = judge_film(points)
    forms = _shown(report, form)
    with parts(outputs) as files:
        if files.data is not None:
            files.data.write_text(snippet(report, form, table.name), encoding="utf-8")
        if files.figure is not None:
            _draw(report, forms, table, files.figure)
    if json:
        from martensite.cli import show

        written = [str(path) for path in outputs.paths()]
        show.as_json({"origin": origin} | report.to_dict() | {"files": written})
    else:
        print_report(report, forms, origin, outputs.paths())


@fit.command("vibration")
def vibration(
    record: Annotated[
        Path, typer.Argument(metavar="RECORD", help="A record with `time` and what vibrates.")
    ],
    column: Annotated[
        str | None, typer.Option(help="Column that vibrates, if there are several.")
    ] = None,
    start: Annotated[
        str | None, typer.Option(help='Time from which on it is free, e.g. "0.5 s".')
    ] = None,
    end: Annotated[str | None, typer.Option(help='Time of the last row used, e.g. "4 s".')] = None,
    cycles: Annotated[int | None, typer.Option(help="Most cycles used; all if left out.")] = None,
    stiffness: Annotated[
        str | None, typer.Option(help='Stiffness, e.g. "540 N/m": gives the moving mass.')
    ] = None,
    mass: Annotated[
        str | None, typer.Option(help='Moving mass, e.g. "190 g": gives the stiffness.')
    ] = None,
    json: Json = False,
) -> None:
    """Frequency and damping from the record of a free vibration.

    RECORD begins at the release, or --start says when that was. The frequency is found from the
    spectrum, then from the times of the extremes; the damping ratio is that of the logarithmic
    decrement over all cycles.
    """
    from martensite.cli.fit_vibration import Oscillator, as_dict, print_vibration, read_vibration

    oscillator = Oscillator.read(stiffness, mass)
    times, values, label = read_vibration(record, column, start, end)
    from martensite.characterise.free_vibration import log_decrement
    from martensite.characterise.spectrum import natural_frequency

    peak = natural_frequency(times, values)
    found = log_decrement(times, values, cycles=cycles, frequency=peak.frequency)
    if json:
        from martensite.cli import show

        show.as_json(as_dict(peak, found, oscillator))
    else:
        print_vibration(peak, found, oscillator, len(times), label)


@fit.command("motor")
def motor(
    steady: Annotated[
        Path,
        typer.Argument(metavar="STEADY", help="Steady states: `voltage`, `current`, `speed`."),
    ],
    locked: Annotated[
        Path | None, typer.Option(help="Rotor held still: `voltage` and `current`.")
    ] = None,
    resistance: Annotated[
        str | None, typer.Option(help='Resistance instead, e.g. "41 ohm".')
    ] = None,
    current_rise: Annotated[
        Path | None, typer.Option(help="Step of the voltage, rotor held: `time` and `current`.")
    ] = None,
    inductance: Annotated[str | None, typer.Option(help='Inductance instead, e.g. "3 mH".')] = None,
    run_up: Annotated[
        Path | None, typer.Option(help="Step of the voltage, rotor free: `time` and `speed`.")
    ] = None,
    json: Json = False,
) -> None:
    """Constants of a DC motor from its tests.

    The resistance and the steady states give K_T = K_B and friction, viscous and dry; a run-up
    gives the inertia. Records of a step begin after it. Speeds are in rad/s or rpm.
    """
    from martensite.cli.fit_motor import (
        print_motor,
        read_inductance,
        read_rise,
        read_steady,
        read_winding,
    )

    winding, coil = read_winding(locked, resistance), read_inductance(inductance)
    states = read_steady(steady)
    from martensite.characterise.motor_constants import estimate_motor_constants

    found = estimate_motor_constants(
        states,
        winding,
        current_rise=read_rise(current_rise, "current"),
        inductance=coil,
        run_up=read_rise(run_up, "speed"),
    )
    if json:
        from martensite.cli import show

        show.as_json(found.to_dict())
    else:
        print_motor(found, len(states.speeds))


@fit.command("tangents")
def tangents(
    logs: Annotated[
        list[str],
        typer.Argument(
            metavar="LOG...",
            help="Isobaric cycles, one per file: `temperature`, `strain` and `stress`; "
            "or data:SET/FILE for files of a published data set.",
        ),
    ],
    stress: Annotated[
        list[str] | None,
        typer.Option(help='Constant stress of each LOG, e.g. "100 MPa"; repeatable.'),
    ] = None,
    cycle: Annotated[
        int | None, typer.Option(help="Which cycle of each LOG, from 1 on; the last if left out.")
    ] = None,
    figure: Figure = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Transformation temperatures, slopes and strain of isobaric cycles, by tangents.

    Each LOG is heated and cooled once through its whole transformation under a constant stress.
    Three straight lines per branch give A_s, A_f, M_s, M_f and the transformation strain; two and
    more stresses give C_A, C_M and the temperatures at zero stress.
    """
    from martensite.cli.fit_tangents import as_dict, draw, fitted, print_tangents, read_cycles
    from martensite.cli.outputs import Outputs, parts

    outputs = Outputs(None, figure).check(force)
    levels = read_cycles(logs, stress, cycle)
    found = fitted(levels)
    with parts(outputs) as files:
        if files.figure is not None:
            draw(levels, found, files.figure)
    if json:
        from martensite.cli import show

        written = [str(path) for path in outputs.paths()]
        show.as_json(as_dict(levels, found) | {"files": written})
    else:
        print_tangents(levels, found, outputs.paths())


def _check_form(form: str, out: Path | None) -> None:
    from martensite.characterise.film_coefficient import FORMS

    if form not in (ALL, *FORMS):
        raise UnknownNameError("form of h(T)", form, (ALL, *FORMS))
    if out is not None and form == ALL:
        listed = ", ".join(f"`{name}`" for name in FORMS)
        raise InputError(f"Option `--out` writes one form of h(T): give --form as one of {listed}.")


def _shown(report: FilmReport, form: str) -> list[str]:
    if form == ALL:
        return list(report.fits)
    if form not in report.fits:
        raise InputError(
            f"{len(report.points)} points do not determine the form `{form}`; "
            "measure at more temperatures, or fit another form."
        )
    return [form]


def _draw(report: FilmReport, forms: list[str], table: Path, path: Path) -> None:
    from martensite.show.figures.files import write_figure
    from martensite.show.figures.film_fit import plot_film

    write_figure(plot_film(report, forms, f"Film coefficient from {table.name}"), path)
