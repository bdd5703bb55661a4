"""What a sweep found, for people and for programs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from martensite.base.status import Status
from martensite.design.sweep.plan import ACCURACY

if TYPE_CHECKING:
    from martensite.design.sweep.plan import Plan
    from martensite.design.sweep.running import Progress
    from martensite.design.sweep.store import Store

NAMED = 5
"""Failed runs that are named."""


@dataclass(frozen=True)
class Swept:
    """A sweep, as far as it is."""

    plan: Plan
    store: Store
    progress: Progress
    part: range
    """Chunks that were asked for."""

    def show(self, json: bool) -> None:
        """Print a summary."""
        from martensite.cli import show

        if json:
            show.as_json(self._report())
            return
        show.table(("measure", "lowest", "median", "highest"), self._rows(),
                   right="lowest,median,highest")  # fmt: skip
        for line in self._lines():
            show.text(line)
        for caution in self.plan.cautions():
            show.text(f"Caution: {caution}", "yellow")
        for remark in (*self._failures(), *self.progress.remarks):
            show.text(f"Warning: {remark}", "yellow")
        show.text(f"wrote {self.store.path}")

    def _lines(self) -> Iterator[str]:
        done = self.progress
        yield f"{done.done:,} of {self.plan.size:,} runs, {done.made:,} of them now, {self._how()}"
        if done.made and done.seconds:
            yield f"{1e3 * done.seconds / done.made:.3g} ms of processor time per run"

    def _how(self) -> str:
        """On what steps, or how accurate."""
        course = self.plan.course
        if course.step is not None:
            return f"in steps of at most {course.step:.3g} s on `{course.runtime}`"
        worst = self._spread(ACCURACY)[2]
        return (
            f"to a tolerance of {course.tolerance:.1e} on `{course.runtime}`; accuracy {worst:.1e} "
            "of range, or better"
        )

    def _failures(self) -> Iterator[str]:
        """Sentences on runs that failed, or are coarse."""
        from martensite.design.sweep.summary import count_above, statuses

        tolerance = self.plan.course.tolerance
        rough = count_above(self.store, ACCURACY, tolerance)
        if rough:
            yield (
                f"{rough:,} runs: the tolerance of {tolerance:.1e} was not reached; `accuracy` "
                "says how far each may be off."
            )
        counts, rows = statuses(self.store, NAMED)
        for status, first in sorted(rows.items()):
            named = ", ".join(map(str, first)) + (" …" if counts[status] > len(first) else "")
            yield f"{counts[status]:,} runs: {Status(status).sentence} (run {named})"

    def _rows(self) -> Iterator[tuple[str, ...]]:
        from martensite.cli import show

        for words, one in self.plan.measures.items():
            unit = one.unit_in(self.plan.course.system)
            yield words, *(show.quantity(v, unit) for v in self._spread(words))

    def _spread(self, words: str) -> tuple[float, ...]:
        """Lowest, median and highest of what there is."""
        from martensite.design.sweep.summary import spread

        return spread(self.store, words)

    def _report(self) -> dict[str, Any]:
        """For JSON; numbers in SI."""
        from martensite.design.sweep.summary import statuses

        counts, _ = statuses(self.store, 0)
        names = ("lowest", "median", "highest")
        return {
            "store": str(self.store.path),
            "runs": self.plan.size,
            "done": self.progress.done,
            "made": self.progress.made,
            "chunks": [len(self.store.made()), self.plan.chunks],
            "step": self.plan.course.step,
            "tolerance": None if self.plan.course.step else self.plan.course.tolerance,
            "accuracy": None if self.plan.course.step else self._spread(ACCURACY)[2],
            "runtime": self.plan.course.runtime,
            "status": {s.name.lower(): counts[s] for s in Status},
            "measures": {
                words: dict(zip(names, self._spread(words), strict=True))
                for words in self.plan.measures
            },
            "cautions": self.plan.cautions(),
            "remarks": self.progress.remarks,
        }
