"""A sweep, as far as it is: ranges of its measures, its effort, and what failed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from martensite.base.formats import write_quantity
from martensite.base.status import Status
from martensite.base.summary import DataTable, Sentence, Summary
from martensite.design.sweep.api import Progress
from martensite.design.sweep.plan import ACCURACY, SweepPlan
from martensite.design.sweep.reading import compute_spread, count_above, count_statuses
from martensite.design.sweep.store import Store

NAMED = 5
"""Failed runs that are named."""
SPREAD = ("lowest", "median", "highest")


def summarise_sweep(plan: SweepPlan, store: Store, progress: Progress) -> Summary:
    """Everything about a sweep.

    Args:
        plan: what is swept.
        store: where it is kept.
        progress: how much of it is made.
    """
    system = plan.course.system
    rows = [
        (words, *(write_quantity(v, one.unit_in(system)) for v in compute_spread(store, words)))
        for words, one in plan.measures.items()
    ]
    warned = (*_tell_failures(plan, store), *progress.remarks)
    blocks = [
        DataTable(("measure", *SPREAD), rows, right=(1, 2, 3)),
        Sentence(f"{progress.done:,} of {plan.size:,} runs, {progress.made:,} of them now, {_tell_steps(plan, store)}"),
        *(Sentence(one) for one in _tell_effort(progress)),
        *(Sentence(f"Caution: {one}", "caution") for one in plan.cautions()),
        *(Sentence(f"Warning: {one}", "caution") for one in warned),
        Sentence(f"wrote {store.path}"),
    ]
    return Summary("", blocks, _collect_numbers(plan, store, progress))


def _tell_effort(progress: Progress) -> Iterator[str]:
    if progress.made and progress.seconds:
        yield f"{1e3 * progress.seconds / progress.made:.3g} ms of processor time per run"


def _tell_steps(plan: SweepPlan, store: Store) -> str:
    """On what steps, or how accurate."""
    course = plan.course
    if course.step is not None:
        return f"in steps of at most {course.step:.3g} s on `{course.runtime}`"
    worst = compute_spread(store, ACCURACY)[2]
    return f"to a tolerance of {course.tolerance:.1e} on `{course.runtime}`; accuracy {worst:.1e} of range, or better"


def _tell_failures(plan: SweepPlan, store: Store) -> Iterator[str]:
    """Sentences on runs that failed, or are coarse."""
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
        "made": progress.made,
        "chunks": [len(store.made()), plan.chunks],
        "step": course.step,
        "tolerance": None if course.step else course.tolerance,
        "accuracy": None if course.step else compute_spread(store, ACCURACY)[2],
        "runtime": course.runtime,
        "status": {s.name.lower(): counts[s] for s in Status},
        "measures": {words: dict(zip(SPREAD, compute_spread(store, words), strict=True)) for words in plan.measures},
        "cautions": plan.cautions(),
        "remarks": progress.remarks,
    }
