"""`pareto`: the runs of a sweep that no other beats."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Option

from martensite.cli.app import app
from martensite.cli.options import StoreFolder, Texts, spread_options
from martensite.cli.outputs import AnswerOptions

if TYPE_CHECKING:
    from martensite.design.sweep.pareto import ParetoFront
    from martensite.design.sweep.table import SweepTable


@app.command()
@spread_options
def pareto(
    store: StoreFolder,
    answer: AnswerOptions,
    minimise: Annotated[
        Texts, Option(metavar="MEASURE", help="What shall be small, a varied number too; repeatable.")
    ] = None,
    maximise: Annotated[Texts, Option(metavar="MEASURE", help="What shall be large; repeatable.")] = None,
    save: Annotated[Path | None, Option(help="Table of the front to write: .csv.")] = None,
) -> None:
    """Find the runs of a sweep that no other beats."""
    from martensite.design.sweep.pareto import find_pareto_front
    from martensite.design.sweep.reading import read_sweep
    from martensite.show.figures.sweep_analysis import plot_pareto
    from martensite.show.summaries.sweep import summarise_front

    outputs = answer.check_files(save, ".csv")
    table = read_sweep(store)
    front = find_pareto_front(table, minimise or (), maximise or ())
    outputs.answer(
        summarise_front(store, table, front),
        answer.json,
        lambda: _write_front(table, front),
        lambda: plot_pareto(table, front),
    )


def _write_front(table: SweepTable, front: ParetoFront) -> str:
    """The front as text: one row per run, numbers in SI, units in the heads."""
    columns, text = front.columns(table), io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["run", *(f"{name} [{c.unit}]" for name, c in columns.items())])
    for run in front.runs:
        writer.writerow([int(run), *(float(c.values[run]) for c in columns.values())])
    return text.getvalue()
