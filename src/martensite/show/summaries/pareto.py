"""A front of a sweep: the runs that no other beats, evenly thinned if there are many."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from martensite.base.summary import DataTable, Sentence, Summary
from martensite.design.sweep.pareto import ParetoFront
from martensite.design.sweep.table import SweepTable

SHOWN = 20
"""Runs of a front that are shown."""


def summarise_front(store: Path, table: SweepTable, front: ParetoFront) -> Summary:
    """Everything about a front."""
    columns, count = front.columns(table), len(front.runs)
    places = np.unique(np.round(np.linspace(0, count - 1, min(SHOWN, count))).astype(int))
    rows = [(str(run), *(c.words(float(c.values[run])) for c in columns.values())) for run in front.runs[places]]
    aims = zip(front.goals, front.most, strict=True)
    goals = ", ".join(f"{'most' if most else 'least'} {one.name}" for one, most in aims)
    blocks = [
        DataTable(("run", *columns), rows, right=range(len(columns) + 1)),
        Sentence(f"{count:,} of {front.compared:,} runs are beaten by no other: {goals}"),
    ]
    if count > len(rows):
        blocks.append(Sentence(f"{len(rows)} of them are shown; --save or --json has all."))
    blocks += [
        Sentence(f"Caution: {number:,} runs are left out: {why}.", "caution")
        for number, why in _count_left_out(table, front)
    ]
    return Summary("", blocks, _collect_numbers(store, table, front))


def _count_left_out(table: SweepTable, front: ParetoFront) -> Iterator[tuple[int, str]]:
    never = len(table.status) - table.missing - table.failed - front.compared
    for count, why in (
        (table.missing, "not made yet"),
        (table.failed, "failed"),
        (never, "what is wanted never happened"),
    ):
        if count:
            yield count, why


def _collect_numbers(store: Path, table: SweepTable, front: ParetoFront) -> dict[str, Any]:
    columns = front.columns(table)
    aims = zip(front.goals, front.most, strict=True)
    return {
        "store": str(store),
        "runs": len(table.status),
        "compared": front.compared,
        "failed": table.failed,
        "missing": table.missing,
        "goals": {one.name: "most" if most else "least" for one, most in aims},
        "front": [
            {"run": int(run), **{name: float(c.values[run]) for name, c in columns.items()}} for run in front.runs
        ],
    }
