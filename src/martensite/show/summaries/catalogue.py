"""The check of the catalogue: the model beside the maker's table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from martensite.base.formats import write_percent
from martensite.base.summary import DataTable, Sentence, Summary
from martensite.design.sizing.catalogue_check import CheckRow, RatioSpread, summarise_ratios
from martensite.physics.materials.base import DOUBTFUL, MaterialNumber
from martensite.show.summaries.sizing import strip_unit, write_seconds

COLUMNS = (
    "wire\nmm",
    "alloy\n°C",
    "1 s pulse\nmA",
    "table\nmA",
    "ratio",
    "cools\ns",
    "table\ns",
    "ratio ",
    "lost\nin 1 s",
    "I²R t\n/stored",
)
DOUBT = "No number is fitted to a size. ! recalled: the original was not seen"


def summarise_check(rows: Sequence[CheckRow], stress: float, ambient: float) -> Summary:
    """The model beside the maker's table, under a stress [Pa] in still air [K]."""
    blocks = [
        Sentence(write_conditions(stress, ambient)),
        DataTable(COLUMNS, [list_cells(row) for row in rows], right=range(2, len(COLUMNS))),
        *map(Sentence, list_spreads(rows)),
        Sentence(DOUBT, "caution"),
    ]
    return Summary("", blocks, collect_check(rows, stress, ambient))


def write_conditions(stress: float, ambient: float) -> str:
    """Under which conditions [Pa, K] the model is set beside the table."""
    return (
        f"The model beside the maker's table: a weight of {stress / 1e6:.4g} MPa, still air of "
        f"{ambient - 273.15:.4g} °C, vertical wire, the last 0.5 % of deformation not counted."
    )


def collect_check(rows: Sequence[CheckRow], stress: float, ambient: float) -> dict[str, Any]:
    """Everything in SI."""
    extra = ("current_ratio", "cooling_ratio")
    return {
        "stress": stress,
        "ambient": ambient,
        "rows": [asdict(row) | {name: getattr(row, name) for name in extra} for row in rows],
        "spread": {alloy: _collect_spreads(rows, alloy) for alloy in _list_alloys(rows)},
    }


def _list_alloys(rows: Sequence[CheckRow]) -> list[str]:
    return list(dict.fromkeys(row.alloy for row in rows))


def _collect_spreads(rows: Sequence[CheckRow], alloy: str) -> dict[str, RatioSpread | None]:
    own = [row for row in rows if row.alloy == alloy]
    return {
        "current": summarise_ratios([row.current_ratio for row in own]),
        "cooling": summarise_ratios([row.cooling_ratio for row in own]),
    }


def list_spreads(rows: Sequence[CheckRow]) -> list[str]:
    """How far the ratios are apart, for each alloy and number."""
    return [
        f"{alloy} °C, {name}: model/catalogue {found.least:.2f} to {found.most:.2f}, geometric mean {found.mean:.2f}"
        for alloy in _list_alloys(rows)
        for name, found in _collect_spreads(rows, alloy).items()
        if found is not None
    ]


def list_cells(row: CheckRow) -> tuple[str, ...]:
    """Its cells below `COLUMNS`."""
    ratio = row.cooling_ratio
    return (
        strip_unit(row.size),
        row.alloy,
        f"{1e3 * row.current:.0f}",
        _mark_cell(row.current_cell, 1e3),
        f"{row.current_ratio:.2f}",
        write_seconds(row.cooling),
        _mark_cell(row.cooling_cell, 1.0),
        "" if ratio is None else f"{ratio:.2f}",
        write_percent(row.loss_share),
        f"{row.stored_share:.2f}",
    )


def _mark_cell(cell: MaterialNumber, scale: float) -> str:
    return ("! " if cell.kind in DOUBTFUL else "") + f"{scale * cell.value:.4g}"
