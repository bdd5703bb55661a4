"""Sensitivities of a sweep: a table per measure, the most important number first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.design.sweep.indices import SensitivityIndices
from martensite.design.sweep.table import SweepTable

HOW = {
    "saltelli": "from blocks of the design `saltelli`",
    "grid": "from the whole grid, its levels equally likely",
    "given data": "from a sample as it is",
}


def summarise_sensitivity(store: Path, table: SweepTable, found: Sequence[SensitivityIndices]) -> Summary:
    """Everything about what the measures of a sweep depend on."""
    data = {
        "store": str(store),
        "sample": table.sample,
        "runs": len(table.status),
        "failed": table.failed,
        "missing": table.missing,
        "measures": {one.measure: _collect_measure(one) for one in found},
    }
    return Summary("", [block for one in found for block in _describe_measure(table, one)], data)


def _describe_measure(table: SweepTable, one: SensitivityIndices) -> Iterator[Block]:
    column = table.measures[one.measure]
    yield Sentence(
        f"{one.measure}: {column.words(one.mean)} on average, standard deviation "
        f"{column.apart(one.deviation)}, {HOW[one.method]} ({one.used:,} runs)"
    )
    if one.deviation:
        kinds = list(one.indices)
        rows = [(one.names[k], *(one.indices[kind].words(k) for kind in kinds)) for k in one.order]
        yield DataTable(("varied", *kinds), rows, right=range(1, len(kinds) + 1))
    yield from (Sentence(f"Caution: {remark}", "caution") for remark in one.remarks)


def _collect_measure(one: SensitivityIndices) -> dict[str, Any]:
    return {
        "method": one.method,
        "used": one.used,
        "mean": one.mean,
        "deviation": one.deviation,
        "unit": one.unit,
        "remarks": one.remarks,
        "indices": {
            kind: {
                name: {"value": float(v), "half_interval": float(w)}
                for name, v, w in zip(one.names, index.values, index.wide, strict=True)
            }
            for kind, index in one.indices.items()
        },
    }
