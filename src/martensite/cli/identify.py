"""`identify LOG...`: a dynamic model of blocks from measured logs, and what it is worth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from martensite.cli.app import app
from martensite.cli.options import Figure, Force, Imports, Json, import_modules

Text = str | None
Texts = list[str] | None


@app.command()
def identify(
    logs: Annotated[
        list[str],
        typer.Argument(
            metavar="LOG...",
            help="Logs to fit, all at once: text with headings such as `position [mm]`, .parquet, "
            ".mat or .nc; or data:SET/FILE.",
        ),
    ],
    inputs: Annotated[
        Texts, typer.Option("--input", metavar="COLUMN", help="Column that goes in; repeatable.")
    ] = None,
    output: Annotated[
        Text,
        typer.Option(
            metavar="COLUMN", help="Column that comes out at the end; several with commas."
        ),
    ] = None,
    stage: Annotated[
        Texts,
        typer.Option(
            metavar="BLOCKS[->COLUMN]",
            help='Blocks in series, e.g. --stage "poly2 | oe(3,3,1) | pwl10"; braces, as in '
            "--search, make a choice of it. Repeated, each stage goes on from the measured column "
            "that the one before names.",
        ),
    ] = None,
    search: Annotated[
        Text,
        typer.Option(
            metavar="PATTERN",
            help='Structures to choose from, e.g. --search "poly{1..3} | oe({2,3},3,1) | pwl10".',
        ),
    ] = None,
    validate: Annotated[
        Texts,
        typer.Option(
            metavar="LOG", help="Log of another cadence that a search chooses by; repeatable."
        ),
    ] = None,
    other: Annotated[
        Texts, typer.Option(metavar="LOG", help="Log that is only scored; repeatable.")
    ] = None,
    interval: Annotated[
        Text, typer.Option(help='Sample time to fit at, e.g. "20 ms" [default: that of the log].')
    ] = None,
    unit: Annotated[
        Texts,
        typer.Option(
            metavar="COLUMN=UNIT", help='Unit of a column in the model, e.g. "duty=%"; repeatable.'
        ),
    ] = None,
    starts: Annotated[int, typer.Option(min=1, help="Searches from different starts.")] = 12,
    seed: Annotated[int, typer.Option(min=0, help="Of the random starts.")] = 0,
    skip: Annotated[
        Text, typer.Option(help='Time at the start of every log that does not count, e.g. "2 s".')
    ] = None,
    initial: Annotated[
        str, typer.Option(help="State at the first row: rest, zero, or estimate.")
    ] = "rest",
    anchor: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            help="Weight of the rest before the input first changes, as a share of all rows "
            "[default: 0.1 where --initial is rest, else 0].",
        ),
    ] = None,
    ridge: Annotated[
        float, typer.Option(min=0.0, help="Pull of free numbers to their start, e.g. 1e-6.")
    ] = 0.0,
    save: Annotated[
        Path | None, typer.Option(metavar="MODEL", help="Model file to write: .json.")
    ] = None,
    figure: Figure = None,
    modules: Imports = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Find a model of blocks that repeats logs in free run.

    Blocks: see `martensite list block`. All scores are of free runs: no measured output is fed
    back.
    --input and --output may be left out where the log leaves no choice, as with two columns
    beside the time. A fit on the logs that it was found from proves little; give --validate a log
    of another cadence. Ctrl-C ends a search and keeps the best so far; the exit code is 1 then.
    """
    import_modules(modules)
    from martensite.cli.identify_run import Given, run_identify
    from martensite.cli.outputs import Outputs

    outputs = Outputs(save, figure).check(force, data=(".json",))
    given = Given(
        logs, inputs or [], output, stage or [], search, validate or [], other or [], interval,
        unit or [], starts, seed, skip, initial, anchor, ridge,
    )  # fmt: skip
    if not run_identify(given, outputs, json):
        raise typer.Exit(1)
