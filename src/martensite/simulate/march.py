"""The march on plain floats: for single runs, in a process that needs no numpy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from martensite.errors import SolveError
from martensite.simulate.compiled import Functions
from martensite.simulate.grid import Grid
from martensite.status import Status

SOLVED = 1e-8
COARSE = 0.2


@dataclass(frozen=True)
class Track:
    """What one march returns: rows of outputs at the samples, and how its steps ended."""

    rows: Sequence[Sequence[float]]
    status: Status
    status_time: float | None
    """Start of the first step with this status [s]; None where it was not recorded."""

    def require(self) -> Track:
        """Return this track, or raise `SolveError` if it cannot be trusted."""
        if self.status.failed:
            when = "during the run" if self.status_time is None else f"{self.status_time:.6g} s"
            raise SolveError(
                f"The coupled step of law, heat and mechanism failed at t = {when}. "
                f"{self.status.sentence}"
            )
        return self


def march_floats(functions: Functions, size: int, grid: Grid) -> Track:
    """Advance through the grid with traced float functions; failures are a status."""
    step, observe = functions["step"], functions["observe"]
    state = functions["init"](*grid.sampled[0])
    rows = [observe(*state, *grid.sampled[0])]
    watch = Watch()
    k = 0
    try:
        for count, drives in zip(grid.counts, grid.sampled[1:], strict=True):
            for u, dt in zip(grid.drives[k : k + count], grid.lengths[k : k + count], strict=True):
                after = step(*state, *u, dt)
                state = after[:size]
                watch.note(after[size], after[size + 1], k)
                k += 1
            rows.append(observe(*state, *drives))
    except ArithmeticError:  # a division by zero or an overflow
        watch.note(math.inf, 0.0, k)
    return track(rows, watch.worst, math.fsum(grid.lengths[: watch.step]))


class Watch:
    """Remembers the worst step and where it was."""

    def __init__(self) -> None:
        self.worst = Status.OK
        self.step = 0

    def note(self, residual: float, crossing: float, step: int) -> None:
        """Classify a step if its report is suspicious; called for every step."""
        if residual <= SOLVED and crossing <= COARSE:
            return
        status = classify(residual, crossing)
        if status > self.worst:
            self.worst, self.step = status, step


def classify(residual: float, crossing: float) -> Status:
    """Status of a step from its report."""
    if math.isnan(residual) or math.isinf(residual):
        return Status.NOT_FINITE
    if residual > SOLVED:
        return Status.UNSOLVED
    return Status.LONG_STEP if crossing > COARSE else Status.OK


def track(rows: Sequence[tuple[float, ...]], status: Status, time: float | None = None) -> Track:
    """A track whose rows have been checked for numbers that are none."""
    finite = all(math.isfinite(value) for row in rows for value in row)
    return Track(list(rows), status if finite else Status.NOT_FINITE, time)


def track_of(table: Any, residual: float, crossing: float, ripple: float) -> Track:
    """A track whose rows are an array (samples, outputs), from its worst reports."""
    import numpy as np

    finite = bool(np.isfinite(table).all())
    status = classify(residual, crossing) if finite else Status.NOT_FINITE
    return Track(table.tolist(), status, None)
