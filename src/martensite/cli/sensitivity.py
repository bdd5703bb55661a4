"""`sensitivity`: what the measures of a sweep depend on."""

from __future__ import annotations

from typing import Annotated

from typer import Option

from martensite.cli.app import app
from martensite.cli.options import StoreFolder, Texts, spread_options
from martensite.cli.outputs import AnswerOptions


@app.command()
@spread_options
def sensitivity(
    store: StoreFolder,
    answer: AnswerOptions,
    output: Annotated[
        Texts, Option(metavar="MEASURE", help="A measure of the sweep; repeatable [default: all].")
    ] = None,
) -> None:
    """Say which numbers of a sweep explain its variance.

    A sweep with `--sample saltelli:1024` gives first and total order with intervals, a whole grid
    both without, any other sample first order, delta and slopes.
    """
    from martensite.design.sweep.indices import compute_sensitivity as find_sensitivity
    from martensite.design.sweep.reading import read_sweep
    from martensite.show.figures.sweep_analysis import plot_sensitivity
    from martensite.show.summaries.sweep import summarise_sensitivity

    outputs = answer.check_files()
    table = read_sweep(store)
    found = find_sensitivity(table, output)
    summary = summarise_sensitivity(store, table, found)
    outputs.answer(summary, answer.json, draw=lambda: plot_sensitivity(found, table.title))
