"""`fit LOG...`: parameters of a scenario from measured logs, and how far to trust them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from martensite.cli.fit import LOGS, fit
from martensite.cli.options import Force, Imports, Json, Settings, import_modules

Text = str | None
Texts = list[str] | None


@fit.command(LOGS)
def fit_logs(
    logs: Annotated[
        list[str],
        typer.Argument(
            metavar="LOG...",
            help="Measured tables with headings such as `strain [%]`, or data:SET/FILE for files "
            "of a published data set; or one fit file (.toml).",
        ),
    ],
    scenario: Annotated[
        list[Path] | None,
        typer.Option(help="Scenario file; one for all logs, or repeated for each."),
    ] = None,
    free: Annotated[
        Texts,
        typer.Option(
            metavar="NAME[=LOW..HIGH UNIT][@START]",
            help='Free parameters, comma-separated or repeated, e.g. A_s,A_f,"C_A=5..12 MPa/K".',
        ),
    ] = None,
    each: Annotated[
        Texts,
        typer.Option(help="What every log has for itself: parameters, offset[.OUTPUT], delay."),
    ] = None,
    hold_out: Annotated[
        Text,
        typer.Option(
            help='Kept back from the fit: auto, none, names of logs, or "25 %" [default: auto].'
        ),
    ] = None,
    column: Annotated[
        Texts,
        typer.Option(
            metavar="OUTPUT[=COLUMN[*FACTOR]]",
            help="What is compared [default: all that log and scenario share]; repeatable.",
        ),
    ] = None,
    noise: Annotated[
        Texts,
        typer.Option(
            metavar="OUTPUT=AMOUNT",
            help='Noise of a measurement, e.g. "strain=0.02 %".',
        ),
    ] = None,
    settings: Settings = None,
    method: Annotated[
        Text, typer.Option(help="trf, coordinate, or evolution [default: trf].")
    ] = None,
    loss: Annotated[
        Text, typer.Option(help="linear, soft-l1, huber, or cauchy [default: linear].")
    ] = None,
    starts: Annotated[
        int | None, typer.Option(help="Further starts spread over the bounds [default: 0].")
    ] = None,
    step: Annotated[
        Text, typer.Option(help='Longest step, e.g. "0.5 s" [default: to the tolerance].')
    ] = None,
    columns: Annotated[
        Text, typer.Option(help="Headings of logs that have none, comma-separated.")
    ] = None,
    interval: Annotated[
        Text, typer.Option(help='Time between rows of logs without times, e.g. "0.1 s".')
    ] = None,
    profile: Annotated[
        Texts, typer.Option(metavar="NAME", help="Profile likelihood of a parameter; repeatable.")
    ] = None,
    posterior: Annotated[
        int | None,
        typer.Option(metavar="DRAWS", help="Posterior samples to draw; needs NumPyro."),
    ] = None,
    resume: Annotated[
        Path | None,
        typer.Option(metavar="STATE", help="File that keeps the search, and takes it up again."),
    ] = None,
    report: Annotated[
        Path | None, typer.Option(help="Report to write: .md (figures beside it) or .html.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="MATERIAL", help="Material file to write: .toml.")
    ] = None,
    modules: Imports = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Fit parameters of a scenario to logs (meant where no other command is named).

    A scenario follows the log where its waveforms are of kind `log`. All other columns that the
    scenario has outputs for are compared. Ctrl-C ends the search and keeps the best so far; the
    exit code is 1 then.
    """
    import_modules(modules)
    from martensite.cli.fit_run import Files, Further, Given, run_fit

    given = Given(
        logs, scenario or [], free or [], each or [], hold_out, column or [], noise or [],
        settings or [], method, loss, starts, step, columns, interval,
    )  # fmt: skip
    files = Files(report, out, resume).check(force)
    if not run_fit(given.task(), files, Further(profile or [], posterior), json):
        raise typer.Exit(1)
