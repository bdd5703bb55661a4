"""Summaries of a sweep: ranges of measures, effort, failures; Pareto front; sensitivities."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from martensite.base.formats import write_quantity
from martensite.base.status import Status
from martensite.base.summary import Block, DataTable, Sentence, Summary
from martensite.design.sweep.api import Progress
from martensite.design.sweep.indices import SensitivityIndices
from martensite.design.sweep.pareto import ParetoFront
from martensite.design.sweep.plan import ACCURACY, SweepPlan
from martensite.design.sweep.reading import compute_spread, count_above, count_statuses
from martensite.design.sweep.store import Store
from martensite.design.sweep.table import SweepTable

NAMED = 5
"""Number of failed runs that are named."""
SPREAD = ("lowest", "median", "highest")
SHOWN = 20
"""Largest number of listed runs of a front."""
HOW = {
    "saltelli": "from blocks of the design `saltelli`",
    "grid": "from the whole grid, its levels equally likely",
    "given data": "from a sample as it is",
}


def summarise_sweep(plan: SweepPlan, store: Store, progress: Progress) -> Summary:
    """Return the summary of a sweep."""
    system = plan.course.system
    rows = [
        (words, *(write_quantity(v, one.unit_in(system)) for v in compute_spread(store, words)))
        for words, one in plan.measures.items()
    ]
    warned = (*_tell_failures(plan, store), *progress.remarks)
    blocks = [
        DataTable(("measure", *SPREAD), rows, right=(1, 2, 3)),
        Sentence(
            f"{progress.done:,} of {plan.size:,} runs, {progress.new_runs:,} of them now, {_tell_steps(plan, store)}"
        ),
        *(Sentence(one) for one in _tell_effort(progress)),
        *(Sentence(f"Caution: {one}", "caution") for one in plan.cautions()),
        *(Sentence(f"Warning: {one}", "caution") for one in warned),
        Sentence(f"wrote {store.path}"),
    ]
    return Summary("", blocks, _collect_numbers(plan, store, progress))


def _tell_effort(progress: Progress) -> Iterator[str]:
    if progress.new_runs and progress.seconds:
        yield f"{1e3 * progress.seconds / progress.new_runs:.3g} ms of processor time per run"


def _tell_steps(plan: SweepPlan, store: Store) -> str:
    course = plan.course
    if course.step is not None:
        return f"in steps of at most {course.step:.3g} s on `{course.runtime}`"
    worst = compute_spread(store, ACCURACY)[2]
    return f"to a tolerance of {course.tolerance:.1e} on `{course.runtime}`; accuracy {worst:.1e} of range, or better"


def _tell_failures(plan: SweepPlan, store: Store) -> Iterator[str]:
    tolerance = plan.course.tolerance
    rough = count_above(store, ACCURACY, tolerance)
    if rough:
        yield (
            f"{rough:,} runs: the tolerance of {tolerance:.1e} was not reached; `accuracy` "
            "says how far each may be off."
        )
    counts, rows = count_statuses(store, NAMED)
    for status, first in sorted(rows.items()):
        named = ", ".join(map(str, first)) + (" …" if counts[status] > len(first) else "")
        yield f"{counts[status]:,} runs: {Status(status).sentence} (run {named})"


def _collect_numbers(plan: SweepPlan, store: Store, progress: Progress) -> dict[str, Any]:
    counts, _ = count_statuses(store, 0)
    course = plan.course
    return {
        "store": str(store.path),
        "runs": plan.size,
        "done": progress.done,
        "made": progress.new_runs,
        "chunks": [len(store.list_finished_chunks()), plan.chunks],
        "step": course.step,
        "tolerance": None if course.step else course.tolerance,
        "accuracy": None if course.step else compute_spread(store, ACCURACY)[2],
        "runtime": course.runtime,
        "status": {s.name.lower(): counts[s] for s in Status},
        "measures": {words: dict(zip(SPREAD, compute_spread(store, words), strict=True)) for words in plan.measures},
        "cautions": plan.cautions(),
        "remarks": progress.remarks,
    }


def summarise_front(store: Path, table: SweepTable, front: ParetoFront) -> Summary:
    """Return the summary of a front."""
    columns, count = front.columns(table), len(front.runs)
    places = np.unique(np.round(np.linspace(0, count - 1, min(SHOWN, count))).astype(int))
    rows = [(str(run), *(c.words(float(c.values[run])) for c in columns.values())) for run in front.runs[places]]
    aims = zip(front.goals, front.most, strict=True)
    goals = ", ".join(f"{'most' if most else 'least'} {one.name}" for one, most in aims)
    blocks = [
        DataTable(("run", *columns), rows, right=range(len(columns) + 1)),
        Sentence(f"{count:,} of {front.compared:,} runs are on the Pareto front: {goals}"),
    ]
    if count > len(rows):
        blocks.append(Sentence(f"{len(rows)} of them are shown; --out or --json has all."))
    blocks += [
        Sentence(f"Caution: {number:,} runs are left out: {why}.", "caution")
        for number, why in _count_left_out(table, front)
    ]
    return Summary("", blocks, _collect_front(store, table, front))


def _count_left_out(table: SweepTable, front: ParetoFront) -> Iterator[tuple[int, str]]:
    never = len(table.status) - table.missing - table.failed - front.compared
    for count, why in (
        (table.missing, "not made yet"),
        (table.failed, "failed"),
        (never, "what is wanted never happened"),
    ):
        if count:
            yield count, why


def _collect_front(store: Path, table: SweepTable, front: ParetoFront) -> dict[str, Any]:
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


def summarise_sensitivity(store: Path, table: SweepTable, indices: Sequence[SensitivityIndices]) -> Summary:
    """Return the sensitivities of the measures of a sweep."""
    data = {
        "store": str(store),
        "sample": table.sample,
        "runs": len(table.status),
        "failed": table.failed,
        "missing": table.missing,
        "measures": {one.measure: _collect_measure(one) for one in indices},
    }
    return Summary("", [block for one in indices for block in _describe_measure(table, one)], data)


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
