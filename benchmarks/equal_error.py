"""Cost at equal error: of every engine the coarsest setting that is within an error.

What: an engine's settings are tried from coarse to fine, once each, until one is within the error;
only those are timed, in interleaved rounds. An engine that reaches the error with no setting is
left out of the rounds and stands in the table without a ratio.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from benchmarks.harness import Candidate, measure

Made = Callable[[], Callable[[], Any]]


class Contender(NamedTuple):
    """One engine with its settings, from coarse to fine; a setting is prepared when it is tried."""

    name: str
    settings: Mapping[str, Made]
    error: Callable[[Any], float]
    per: int = 1


def coarsest(contender: Contender, level: float) -> Candidate | None:
    """The first setting within an error; None if there is none."""
    for label, make in contender.settings.items():
        run = make()
        if contender.error(run()) <= level:
            return Candidate(contender.name, run, contender.error, contender.per, label)
    return None


def equal_error(contenders: Sequence[Contender], level: float, repeats: int, base: str) -> list[dict[str, Any]]:
    """A row for each engine; the ratio is of CPU time to that of `base`, at its own setting."""
    found = {c.name: coarsest(c, level) for c in contenders}
    able = [candidate for candidate in found.values() if candidate]
    timings = {t.name: t for t in measure(able, repeats, base)} if able else {}
    rows: list[dict[str, Any]] = []
    for contender in contenders:
        t = timings.get(contender.name)
        rows.append(
            {
                "engine": contender.name,
                "setting": t.setting if t else "none reaches it",
                "err": t.err if t else None,
                "spread": t.spread if t else None,
                "ratio": t.ratio if t else None,
            }
        )
    return rows
