"""Batches of problem B for the section `mas`: ours, LSODA one by one, Kvaerno5 by vmap.

What: wires around a given one, on SIMD lanes of C at several steps, and in lanes of C with an
error control. A big batch is cut to what takes about a
second. The first sets are judged, each against its own reference; an engine of which any set
fails has failed.
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np

from benchmarks import mas_runs
from benchmarks.harness import Candidate
from benchmarks.mas_runs import LANES, Problem
from benchmarks.peers import mas_ode
from benchmarks.problem_b import Wire

JUDGED = 4
FEW = 8  # sets of a peer that runs them one by one
MOST = 1.5  # [s] of one call, as far as one chunk allows
DIFFRAX = importlib.util.find_spec("diffrax") is not None
LSODA_C = importlib.util.find_spec("numbalsoda") is not None


@cache
def reference(p: Wire, form: str) -> Any:
    """x [mm], stress [Pa], strain [1] on the output grid."""
    run = mas_ode.trajectory(mas_ode.by_radau, p, form, 1e-10)
    return mas_ode.outcome(p, run())


def errors(x: Any, exact: Any) -> tuple[float, float]:
    """rms and largest difference over the range."""
    gap = np.abs(np.asarray(x) - exact) / np.ptp(exact)
    return float(np.sqrt(np.mean(gap**2))), float(gap.max())


class Judge:
    """rms error of batches against their references, and how many sets failed."""

    def __init__(self, sets: Sequence[Wire]) -> None:
        self.exact = [reference(p, "edge")[0] for p in sets[:JUDGED]]
        self.failed: dict[tuple[str, str], int] = {}

    def candidate(self, name: str, setting: str, run: Callable[[], Any], count: int) -> Candidate:
        """A batch of `count` sets whose result is judged."""

        def error(x: Any) -> float:
            self.failed[name, setting] = failed = int((~np.isfinite(x).all(axis=1)).sum())
            worst = max(errors(a, b)[0] for a, b in zip(x, self.exact, strict=False))
            return float("nan") if failed else worst

        return Candidate(name, run, error, count, setting)


def library(judge: Judge, sets: list[Wire], settings: dict[str, Sequence[float]]) -> list[Candidate]:
    """Ours: engine -> steps [ms], or tolerances."""
    problem, found = Problem(sets[0]), []
    for name, make in mas_runs.BATCH.items():
        for setting in mas_runs.settings_of(name, settings[name]):
            run, count = cut(make, problem, sets, setting.value)
            found.append(judge.candidate(name, setting.label, run, count))
    return found


def cut(make: Any, problem: Problem, sets: list[Wire], setting: float) -> tuple[Callable[[], Any], int]:
    """A batch of as many chunks as take about `MOST` seconds, and its number of sets."""
    chunk = min(LANES, len(sets))
    one = make(problem, sets[:chunk], setting)
    one()
    begin = time.process_time()
    one()
    count = round(MOST / max(time.process_time() - begin, 1e-6))
    size = chunk * max(1, min(len(sets) // chunk, count))
    return make(problem, sets[:size], setting), size


def in_turn(sets: Sequence[Wire], make: Callable[[Wire], Callable[[], Any]]) -> Callable[[], Any]:
    """Return x [mm] of all sets by a solver that runs one set after another."""
    runs = [make(p) for p in sets]
    return lambda: np.array([mas_ode.outcome(p, run())[0] for p, run in zip(sets, runs, strict=True)])


def odeint(sets: Sequence[Wire], rtol: float) -> Callable[[], Any]:
    """Return x [mm] of all sets by `odeint`."""
    return in_turn(sets, lambda p: mas_ode.trajectory(mas_ode.by_odeint, p, "edge", rtol))


def lsoda_c(sets: Sequence[Wire], rtol: float) -> Callable[[], Any]:
    """Return x [mm] of all sets by LSODA in C."""
    from benchmarks.peers import mas_lsoda_c

    return in_turn(sets, lambda p: mas_lsoda_c.trajectory(p, rtol))


def lsoda(judge: Judge, sets: Sequence[Wire], rtols: Sequence[int]) -> list[Candidate]:
    """LSODA, one set after another."""
    few = sets[:FEW]
    solvers = {"LSODA": odeint} | ({"LSODA in C": lsoda_c} if LSODA_C else {})
    return [
        judge.candidate(name, f"rtol 1e-{n}", solve(few, 10.0**-n), len(few))
        for name, solve in solvers.items()
        for n in rtols
    ]


def kvaerno(judge: Judge, sets: Sequence[Wire], rtols: Sequence[int]) -> list[Candidate]:
    """Kvaerno5 by vmap, one chunk."""
    if not DIFFRAX or not rtols:
        return []
    from benchmarks.peers import mas_diffrax

    some, found = list(sets[:LANES]), []
    for n in rtols:
        solve = mas_diffrax.batch(some, "edge", 10.0**-n)

        def run(solve: Any = solve) -> Any:
            pairs = zip(some, solve(), strict=True)
            return np.array([mas_ode.outcome(p, states)[0] for p, states in pairs])

        found.append(judge.candidate("Kvaerno5", f"rtol 1e-{n}", run, len(some)))
    return found
