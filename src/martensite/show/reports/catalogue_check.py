"""The check of the catalogue in rows: the model beside the maker's table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from martensite.design.sizing.catalogue_check import CheckRow, Spread, spread
from martensite.physics.materials.base import DOUBTFUL, MaterialNumber
from martensite.show.reports.sizing import bare, percent, seconds

COLUMNS = ("wire\nmm", "alloy\n°C", "1 s pulse\nmA", "table\nmA", "ratio", "cools\ns", "table\ns",
           "ratio ", "lost\nin 1 s", "I²R t\n/stored")  # fmt: skip
DOUBT = "No number is fitted to a size. ! recalled: the original was not seen"


def conditions(stress: float, ambient: float) -> str:
    """Under which conditions [Pa, K] the model is set beside the table."""
    return (
        f"The model beside the maker's table: a weight of {stress / 1e6:.4g} MPa, still air of "
        f"{ambient - 273.15:.4g} °C, vertical wire, the last 0.5 % of deformation not counted."
    )


def check_report(rows: Sequence[CheckRow], stress: float, ambient: float) -> dict[str, Any]:
    """Everything in SI."""
    extra = ("current_ratio", "cooling_ratio")
    return {
        "stress": stress,
        "ambient": ambient,
        "rows": [asdict(row) | {name: getattr(row, name) for name in extra} for row in rows],
        "spread": {alloy: _spreads(rows, alloy) for alloy in _alloys(rows)},
    }


def _alloys(rows: Sequence[CheckRow]) -> list[str]:
    return list(dict.fromkeys(row.alloy for row in rows))


def _spreads(rows: Sequence[CheckRow], alloy: str) -> dict[str, Spread | None]:
    own = [row for row in rows if row.alloy == alloy]
    return {
        "current": spread([row.current_ratio for row in own]),
        "cooling": spread([row.cooling_ratio for row in own]),
    }


def spread_sentences(rows: Sequence[CheckRow]) -> list[str]:
    """How far the ratios are apart, for each alloy and number."""
    return [
        f"{alloy} °C, {name}: model/catalogue {found.least:.2f} to {found.most:.2f}, "
        f"geometric mean {found.mean:.2f}"
        for alloy in _alloys(rows)
        for name, found in _spreads(rows, alloy).items()
        if found is not None
    ]


def cells(row: CheckRow) -> tuple[str, ...]:
    """Its cells below `COLUMNS`."""
    ratio = row.cooling_ratio
    return (
        bare(row.size), row.alloy, f"{1e3 * row.current:.0f}", _marked(row.current_cell, 1e3),
        f"{row.current_ratio:.2f}", seconds(row.cooling), _marked(row.cooling_cell, 1.0),
        "" if ratio is None else f"{ratio:.2f}", percent(row.loss_share),
        f"{row.stored_share:.2f}",
    )  # fmt: skip


def _marked(cell: MaterialNumber, scale: float) -> str:
    return ("! " if cell.kind in DOUBTFUL else "") + f"{scale * cell.value:.4g}"
