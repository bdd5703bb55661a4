"""`pareto`: the runs of a sweep that no other beats."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from martensite.cli.app import app
from martensite.cli.options import Figure, Force, Json
from martensite.cli.sensitivity import StoreFolder

if TYPE_CHECKING:
    from martensite.design.sweep.pareto import ParetoFront
    from martensite.design.sweep.table import SweepTable

SHOWN = 20
"""Runs of a front that are printed."""


@app.command()
def pareto(
    store: StoreFolder,
    minimise: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MEASURE", help="What shall be small, a varied number too; repeatable."
        ),
    ] = None,
    maximise: Annotated[
        list[str] | None, typer.Option(metavar="MEASURE", help="What shall be large; repeatable.")
    ] = None,
    save: Annotated[Path | None, typer.Option(help="Table of the front to write: .csv.")] = None,
    figure: Figure = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Find the runs of a sweep that no other beats."""
    from martensite.cli import show
    from martensite.cli.outputs import Outputs
    from martensite.design.sweep.pareto import pareto_front
    from martensite.design.sweep.reading import read_sweep

    outputs = Outputs(save, figure).check(force, data=(".csv",))
    table = read_sweep(store)
    front = pareto_front(table, minimise or (), maximise or ())
    if save is not None:
        _write(table, front, save)
    if figure is not None:
        _draw(table, front, figure)
    if json:
        show.as_json(_report(store, table, front))
        return
    _show(table, front)
    for path in outputs.paths():
        show.text(f"wrote {path}")


def _show(table: SweepTable, front: ParetoFront) -> None:
    """The front as a table, evenly thinned if it is long."""
    import numpy as np

    from martensite.cli import show

    columns = front.columns(table)
    count = len(front.runs)
    places = np.unique(np.round(np.linspace(0, count - 1, min(SHOWN, count))).astype(int))
    rows = [
        (str(run), *(c.words(float(c.values[run])) for c in columns.values()))
        for run in front.runs[places]
    ]
    show.table(("run", *columns), rows, right=",".join(("run", *columns)))
    aims = zip(front.goals, front.most, strict=True)
    goals = ", ".join(f"{'most' if most else 'least'} {one.name}" for one, most in aims)
    show.text(f"{count:,} of {front.compared:,} runs are beaten by no other: {goals}")
    if count > len(rows):
        show.text(f"{len(rows)} of them are shown; --save or --json has all.")
    for number, why in _left_out(table, front):
        show.text(f"Caution: {number:,} runs are left out: {why}.", "yellow")


def _left_out(table: SweepTable, front: ParetoFront) -> list[tuple[int, str]]:
    never = len(table.status) - table.missing - table.failed - front.compared
    counts = (
        (table.missing, "not made yet"),
        (table.failed, "failed"),
        (never, "what is wanted never happened"),
    )
    return [(count, why) for count, why in counts if count]


def _report(store: Path, table: SweepTable, front: ParetoFront) -> dict[str, Any]:
    """For JSON; numbers in SI."""
    columns = front.columns(table)
    return {
        "store": str(store),
        "runs": len(table.status),
        "compared": front.compared,
        "failed": table.failed,
        "missing": table.missing,
        "goals": {
            one.name: "most" if most else "least"
            for one, most in zip(front.goals, front.most, strict=True)
        },
        "front": [
            {"run": int(run), **{name: float(c.values[run]) for name, c in columns.items()}}
            for run in front.runs
        ],
    }


def _write(table: SweepTable, front: ParetoFront, path: Path) -> None:
    """The front as text: one row per run, numbers in SI, units in the heads."""
    import csv

    from martensite.base.files import replace_file

    columns = front.columns(table)
    with replace_file(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["run", *(f"{name} [{c.unit}]" for name, c in columns.items())])
        for run in front.runs:
            writer.writerow([int(run), *(float(c.values[run]) for c in columns.values())])


def _draw(table: SweepTable, front: ParetoFront, path: Path) -> None:
    from martensite.show.figures.files import write_figure
    from martensite.show.figures.pareto import plot_pareto

    write_figure(plot_pareto(table, front), path)
