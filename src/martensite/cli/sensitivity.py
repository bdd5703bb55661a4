"""`sensitivity`: what the measures of a sweep depend on."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from martensite.cli.app import app
from martensite.cli.options import Figure, Json

if TYPE_CHECKING:
    from martensite.design.sweep.indices import Sensitivity
    from martensite.design.sweep.table import SweepTable

StoreFolder = Annotated[Path, typer.Argument(metavar="STORE", help="A sweep (Zarr).")]
HOW = {
    "saltelli": "from blocks of the design `saltelli`",
    "grid": "from the whole grid, its levels equally likely",
    "given data": "from a sample as it is",
}


@app.command()
def sensitivity(
    store: StoreFolder,
    output: Annotated[
        list[str] | None,
        typer.Option(metavar="MEASURE", help="A measure of the sweep; repeatable [default: all]."),
    ] = None,
    figure: Figure = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing figure.")] = False,
    json: Json = False,
) -> None:
    """Say which numbers of a sweep explain its variance.

    A sweep with `--sample saltelli:1024` gives first and total order with intervals, a whole grid
    both without, any other sample first order, delta and slopes.
    """
    from martensite.cli import show
    from martensite.cli.outputs import Outputs
    from martensite.design.sweep.indices import sensitivity as found_of
    from martensite.design.sweep.reading import read_sweep

    outputs = Outputs(None, figure).check(force)
    table = read_sweep(store)
    found = found_of(table, output)
    if figure is not None:
        _draw(found, table.title, figure)
    if json:
        show.as_json(_report(store, table, found))
        return
    for one in found:
        _show(table, one)
    for path in outputs.paths():
        show.text(f"wrote {path}")


def _show(table: SweepTable, one: Sensitivity) -> None:
    """A table of one measure, the most important number first."""
    from martensite.cli import show

    column = table.measures[one.measure]
    mean = column.words(one.mean)
    show.text(
        f"{one.measure}: {mean} on average, standard deviation {column.apart(one.deviation)}, "
        f"{HOW[one.method]} ({one.used:,} runs)"
    )
    kinds = list(one.indices) if one.deviation else []
    rows = [(one.names[k], *(one.indices[kind].words(k) for kind in kinds)) for k in one.order]
    if kinds:
        show.table(("varied", *kinds), rows, right=",".join(kinds))
    for remark in one.remarks:
        show.text(f"Caution: {remark}", "yellow")


def _report(store: Path, table: SweepTable, found: list[Sensitivity]) -> dict[str, Any]:
    """For JSON; numbers in SI."""
    return {
        "store": str(store),
        "sample": table.sample,
        "runs": len(table.status),
        "failed": table.failed,
        "missing": table.missing,
        "measures": {
            one.measure: {
                "method": one.method, "used": one.used, "mean": one.mean,
                "deviation": one.deviation, "unit": one.unit, "remarks": one.remarks,
                "indices": {
                    kind: {
                        name: {"value": float(v), "half_interval": float(w)}
                        for name, v, w in zip(one.names, index.values, index.wide, strict=True)
                    }
                    for kind, index in one.indices.items()
                },
            }
            for one in found
        },
    }  # fmt: skip


def _draw(found: list[Sensitivity], title: str, path: Path) -> None:
    from martensite.show.figures.files import write_figure
    from martensite.show.figures.sensitivity import plot_sensitivity

    write_figure(plot_sensitivity(found, title), path)
