"""The section `mas`: problem B at equal error, and the hybrid law against the stiff equations.

What: positions are judged against Radau at rtol 1e-10, which meets the printed numbers of
`problem_b` (Rodas4); rms and largest error are shares of the range. LSODA and Radau have their
right-hand side in Python and restart at the kinks of the input; Kvaerno5 runs where diffrax is
installed. Of a batch the first few sets are judged, each against its own reference.
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from benchmarks import mas_runs
from benchmarks.harness import Candidate, Timing, measure
from benchmarks.mas_runs import LANES, Problem, parameter_sets
from benchmarks.peers import mas_ode
from benchmarks.problem_b import REFERENCE, Wire, stiff
from benchmarks.report import Table
from benchmarks.sections import Options, section
from benchmarks.sections_laws import ours
from martensite.runtimes.bracket import ITERATIONS

WIRES = {"nominal": Wire(), "stiff": stiff(Wire())}
LEVELS = (1e-4, 1e-5, 1e-6)
JUDGED = 4
MOST = 1.5  # [s] of one call of a batch, as far as one chunk allows
DIFFRAX = importlib.util.find_spec("diffrax") is not None
BASES = ("LSODA", "Radau", "Kvaerno5")
MPA, PERCENT, TIMES = 0.5, 0.05, 10.0  # the bar of the hybrid law


class Effort(NamedTuple):
    """Accuracy settings that are tried; the tests try fewer."""

    floats: Sequence[float] = (100, 50, 20, 10)  # [ms]
    jax: Sequence[float] = (100, 20, 10)  # [ms]; every step length compiles again
    c: Sequence[float] = (100, 50, 20, 10, 5, 2)  # [ms]
    rtols: Sequence[int] = (3, 4, 5, 6, 7)  # 10^-n
    batch: Sequence[tuple[float, int]] = ((50, 6), (20, ITERATIONS), (10, ITERATIONS))
    hybrid: Sequence[float] = (100, 50, 20)  # [ms]
    hybrid_jax: Sequence[float] = (100,)

    def steps(self, engine: str) -> Sequence[float]:
        """Of a single run of problem B [ms]."""
        return {"ours, floats": self.floats, "ours, JAX": self.jax}.get(engine, self.c)


USUAL = Effort()


@cache
def reference(p: Wire, form: str) -> Any:
    """x [mm], stress [Pa], strain [1] on the output grid."""
    run = mas_ode.trajectory(mas_ode.by_radau, p, form, 1e-10)
    return mas_ode.outcome(p, run())


def errors(x: Any, exact: Any) -> tuple[float, float]:
    """rms and largest difference over the range."""
    gap = np.abs(np.asarray(x) - exact) / np.ptp(exact)
    return float(np.sqrt(np.mean(gap**2))), float(gap.max())


def peers(p: Wire, form: str, rtols: Sequence[int]) -> dict[tuple[str, str], Callable[[], Any]]:
    """Runs of (engine, setting) that return x, stress and strain."""
    found: dict[tuple[str, str], Callable[[], Any]] = {}
    for n in rtols:
        runs = {k: mas_ode.trajectory(s, p, form, 10.0**-n) for k, s in mas_ode.SOLVERS.items()}
        if DIFFRAX:
            from benchmarks.peers import mas_diffrax

            runs["Kvaerno5"] = mas_diffrax.trajectory(p, form, 10.0**-n)
        for name, run in runs.items():
            found[name, f"rtol 1e-{n}"] = lambda run=run: mas_ode.outcome(p, run())
    return dict(sorted(found.items()))


def library(problem: Problem, steps: Callable[[str], Sequence[float]]) -> dict[Any, Any]:
    """The same of the library."""
    return {
        (name, f"dt {ms:g} ms"): make(problem, 1e-3 * ms)
        for name, make in mas_runs.SINGLE.items()
        for ms in steps(name)
    }


class Judge(NamedTuple):
    """Keeps what a table says about a result beside its rms error."""

    exact: Any
    said: dict[tuple[str, str], dict[str, Any]]

    def of(self, key: tuple[str, str]) -> Callable[[Any], float]:
        """rms error of x; the rest is noted."""

        def error(found: Any) -> float:
            rms, largest = errors(found[0], self.exact[0])
            self.said[key] = {
                "err max": largest,
                "stress [MPa]": float(np.abs(found[1] - self.exact[1]).max()) / 1e6,
                "strain [%]": 100.0 * float(np.abs(found[2] - self.exact[2]).max()),
            }
            return rms

        return error


def timed(runs: dict[Any, Any], exact: Any, repeats: int) -> tuple[list[Timing], Judge]:
    """All runs in interleaved rounds."""
    judge = Judge(exact, {})
    candidates = [Candidate(k[0], run, judge.of(k), setting=k[1]) for k, run in runs.items()]
    return measure(candidates, repeats), judge


def equal_error(timings: Sequence[Timing], unit: str, factor: float) -> list[dict[str, Any]]:
    """The cheapest setting of each engine that reaches each error, and LSODA's over it."""
    rows = []
    for name in dict.fromkeys(t.name for t in timings):
        row: dict[str, Any] = {"engine": name}
        for level in LEVELS:
            best = cheapest(timings, name, level)
            base = cheapest(timings, "LSODA", level)
            row[f"{level:.0e} [{unit}]"] = factor * best if best else None
            row[f"LSODA/this {level:.0e}"] = base / best if best and base else None
        rows.append(row)
    return rows


def cheapest(timings: Sequence[Timing], name: str, level: float) -> float | None:
    """CPU seconds of an engine's cheapest setting with at most this error."""
    return min((t.cpu for t in timings if t.name == name and t.err <= level), default=None)


def single_tables(options: Options, label: str, effort: Effort) -> list[Table]:
    """Single runs of one wire: every setting, and cost at equal error."""
    p = WIRES[label]
    runs = peers(p, "edge", effort.rtols)
    if ours(options):
        runs = library(Problem(p), effort.steps) | runs
    exact = reference(p, "edge")
    timings, judge = timed(runs, exact, options.repeats)
    rows = [
        {"engine": t.name, "setting": t.setting, "err": t.err}
        | {"err max": judge.said[t.name, t.setting]["err max"]}
        | {"cpu [ms]": 1e3 * t.cpu, "spread": t.spread}
        for t in timings
    ]
    note = ""
    if label == "nominal":
        off = max(abs(exact[0][round(10 * t)] - x) for t, (x, *_) in REFERENCE.items())
        note = f"The reference is within {off:.1e} mm of the printed numbers (Rodas4)."
    return [
        Table(f"Problem B, {label}: single runs", rows, note),
        Table(f"Problem B, {label}: at equal error (rms)", equal_error(timings, "ms", 1e3)),
    ]


# ---------------------------------------------------------------- batches


def batch_runs(
    options: Options, label: str, size: int, effort: Effort
) -> tuple[list[Candidate], dict[Any, int]]:
    """Batches around one wire, and the number of sets that failed in each."""
    sets = parameter_sets(WIRES[label], size)
    exact = [reference(p, "edge")[0] for p in sets[:JUDGED]]
    failed: dict[Any, int] = {}

    def judge(key: Any) -> Callable[[Any], float]:
        def error(x: Any) -> float:
            failed[key] = int((~np.isfinite(x).all(axis=1)).sum())
            if failed[key]:
                return float("nan")
            return max(errors(a, b)[0] for a, b in zip(x, exact, strict=False))

        return error

    found = []
    for name, make in mas_runs.BATCH.items() if ours(options) else ():
        for ms, n in effort.batch:
            key = name, f"dt {ms:g} ms, N {n}"
            run, count = cut(make, Problem(WIRES[label]), sets, 1e-3 * ms, n)
            found.append(Candidate(name, run, judge(key), count, key[1]))
    return found + peer_batches(sets, effort.rtols, judge), failed


def cut(
    make: Any, problem: Problem, sets: list[Wire], step: float, iterations: int
) -> tuple[Callable[[], Any], int]:
    """A batch of as many chunks as take about `MOST` seconds, and its number of sets."""
    chunk = min(LANES, len(sets))
    one = make(problem, sets[:chunk], step, iterations)
    one()
    begin = time.process_time()
    one()
    count = round(MOST / max(time.process_time() - begin, 1e-6))
    size = chunk * max(1, min(len(sets) // chunk, count))
    return make(problem, sets[:size], step, iterations), size


def peer_batches(sets: list[Wire], rtols: Sequence[int], judge: Any) -> list[Candidate]:
    """LSODA one set after another, and Kvaerno5 by vmap."""
    found = []
    few = sets[:8]
    for n in rtols:
        one = [mas_ode.trajectory(mas_ode.by_odeint, p, "edge", 10.0**-n) for p in few]

        def each(one: Any = one) -> Any:
            return np.array([mas_ode.outcome(p, run())[0] for p, run in zip(few, one, strict=True)])

        key = "LSODA", f"rtol 1e-{n}"
        found.append(Candidate(key[0], each, judge(key), len(few), key[1]))
    if DIFFRAX:
        found.append(kvaerno_batch(sets[:LANES], judge))
    return found


def kvaerno_batch(sets: list[Wire], judge: Any, n: int = 4) -> Candidate:
    """Kvaerno5 by vmap at one tolerance."""
    from benchmarks.peers import mas_diffrax

    solve = mas_diffrax.batch(sets, "edge", 10.0**-n)
    key = "Kvaerno5", f"rtol 1e-{n}"

    def run() -> Any:
        return np.array([mas_ode.outcome(p, y)[0] for p, y in zip(sets, solve(), strict=True)])

    return Candidate(key[0], run, judge(key), len(sets), key[1])


def batch_tables(options: Options, label: str, size: int, effort: Effort) -> list[Table]:
    """A batch around one wire: every setting, and cost at equal error."""
    runs, failed = batch_runs(options, label, size, effort)
    timings = measure(runs, options.repeats)
    rows = [
        {"engine": t.name, "setting": t.setting, "sets run": run.per}
        | {"failed": failed[t.name, t.setting], "err": t.err}
        | {"cpu [us]": 1e6 * t.cpu, "spread": t.spread}
        for t, run in zip(timings, runs, strict=True)
    ]
    note = (
        f"Per trajectory; err: worst rms of the first {JUDGED} sets, `failed` where any set is "
        "unsolved; N: iterations of the coupled step."
    )
    title = f"Problem B, {label}: batch of {size}"
    return [
        Table(title, rows, note),
        Table(f"{title}, at equal error (rms)", equal_error(timings, "us", 1e6)),
    ]


# ---------------------------------------------------------------- the hybrid law


def good(said: dict[str, Any]) -> bool:
    """Whether an error is within the bar."""
    return said["stress [MPa]"] <= MPA and said["strain [%]"] <= PERCENT


def hybrid_tables(options: Options, effort: Effort) -> list[Table]:
    """`mas-hybrid` on the wire of problem B against the rate law with the barrier form."""
    problem, exact = Problem(Wire(), "mas-hybrid"), reference(Wire(), "barrier")
    runs = peers(Wire(), "barrier", effort.rtols)
    if ours(options):

        def steps(name: str) -> Sequence[float]:
            return effort.hybrid_jax if name == "ours, JAX" else effort.hybrid

        runs = library(problem, steps) | runs
    timings, judge = timed(runs, exact, options.repeats)
    said = [judge.said[t.name, t.setting] for t in timings]
    rows = [
        {"engine": t.name, "setting": t.setting, **notes, "err": t.err}
        | {"cpu [ms]": 1e3 * t.cpu, "spread": t.spread}
        for t, notes in zip(timings, said, strict=True)
    ]
    note = "Largest differences to the barrier form of the rate law by Radau, rtol 1e-10."
    tables = [Table("Problem B with mas-hybrid against its stiff equations", rows, note)]
    if ours(options):
        tables.append(bars(timings, said))
    return tables


def bars(timings: Sequence[Timing], said: Sequence[dict[str, Any]]) -> Table:
    """The cheapest good setting of each runtime against the peers."""
    rows = []
    fit = [t for t, notes in zip(timings, said, strict=True) if good(notes)]
    for name in mas_runs.SINGLE:
        best = min((t.cpu for t in fit if t.name == name), default=None)
        row: dict[str, Any] = {"engine": name, "cpu [ms]": best and 1e3 * best}
        for base in BASES:
            tight = [t.cpu for t in timings if (t.name, t.setting) == (base, "rtol 1e-6")]
            loose = [t.cpu for t in fit if t.name == base]
            row[f"{base} 1e-6 / this"] = tight[0] / best if tight and best else None
            row[f"{base} good / this"] = min(loose) / best if loose and best else None
        ratios = [row[f"{b} 1e-6 / this"] for b in BASES[1:] if row[f"{b} 1e-6 / this"]]
        row[f">= {TIMES:g}x"] = "yes" if ratios and min(ratios) >= TIMES else "NO"
        rows.append(row)
    note = (
        f"Cheapest setting within {MPA} MPa and {PERCENT} % strain; `good`: the peer's cheapest "
        "setting within the same. The bar is on Radau and Kvaerno5 at rtol 1e-6."
    )
    return Table("mas-hybrid: times faster than its stiff equations", rows, note)


@section
def mas(options: Options, effort: Effort = USUAL) -> list[Table]:
    """Problem B and its stiff variant, single and in batches; the hybrid law."""
    tables = [table for label in WIRES for table in single_tables(options, label, effort)]
    sizes = sorted(size for size in options.sizes if size > 1)
    for label, size in [*(("nominal", size) for size in sizes), ("stiff", sizes[0])]:
        tables += batch_tables(options, label, size, effort)
    return tables + hybrid_tables(options, effort)
