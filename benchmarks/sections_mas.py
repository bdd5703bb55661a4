"""The section `mas`: problem B at equal error, and the hybrid law against the stiff equations.

What: positions are judged against Radau at rtol 1e-10, which meets the printed numbers of
`problem_b` (Rodas4); rms and largest error are shares of the range. LSODA and Radau have their
right-hand side in Python and restart at the kinks of the input; LSODA in C runs where numbalsoda is
installed, Kvaerno5 where diffrax is. Of a batch the first few sets are judged, each against its own reference.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks import mas_batches, mas_runs
from benchmarks.harness import Candidate, Timing, measure
from benchmarks.mas_batches import DIFFRAX, LSODA_C, errors, reference
from benchmarks.mas_runs import Problem, parameter_sets
from benchmarks.peers import mas_ode
from benchmarks.problem_b import REFERENCE, Wire, stiff
from benchmarks.report import Table
from benchmarks.sections import Options, section
from benchmarks.sections_laws import ours

WIRES = {"nominal": Wire(), "stiff": stiff(Wire())}
LEVELS = (1e-4, 1e-5, 1e-6)
BASES = ("LSODA", "Radau", "Kvaerno5")
RATIO = "Ratio: LSODA's CPU time over this one, each at its cheapest setting within the error."
MPA, PERCENT, TIMES = 0.5, 0.05, 10.0  # the bar of the hybrid law


class Effort(NamedTuple):
    """Accuracy settings that are tried, steps in [ms]; the tests try fewer."""

    floats: Sequence[float] = (100, 50, 20, 10)
    c: Sequence[float] = (100, 50, 20, 10, 5, 2)
    rtols: Sequence[int] = (3, 4, 5, 6, 7)  # 10^-n, of LSODA and Radau
    kvaerno: Sequence[int] = (3, 4, 5, 6)
    simd_batch: Sequence[float] = (50, 20, 10)
    kvaerno_batch: Sequence[int] = (4,)
    hybrid: Sequence[float] = (100, 50, 20)
    march: Sequence[float] = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6)
    march_batch: Sequence[float] = (3e-3, 1e-3, 3e-4, 1e-4)

    def steps(self, law: str) -> dict[str, Sequence[float]]:
        """Of single runs, by engine; tolerances of the march."""
        floats, c = (self.hybrid, self.hybrid) if law == "mas-hybrid" else (self.floats, self.c)
        return {FLOATS: floats, C: c, MARCH: self.march, CALL: self.march}


FLOATS, C, MARCH, CALL = mas_runs.SINGLE
USUAL = Effort()


def peers(p: Wire, form: str, effort: Effort) -> dict[tuple[str, str], Callable[[], Any]]:
    """Runs of (engine, setting) that return x, stress and strain."""
    runs: dict[tuple[str, str], Callable[[], Any]] = {
        (name, f"rtol 1e-{n}"): mas_ode.trajectory(solve, p, form, 10.0**-n)
        for name, solve in mas_ode.SOLVERS.items()
        for n in effort.rtols
    }
    if LSODA_C and form == "edge":
        from benchmarks.peers import mas_lsoda_c

        for n in effort.rtols:
            runs["LSODA in C", f"rtol 1e-{n}"] = mas_lsoda_c.trajectory(p, 10.0**-n)
    if DIFFRAX and effort.kvaerno:
        from benchmarks.peers import mas_diffrax

        for n in effort.kvaerno:
            runs["Kvaerno5", f"rtol 1e-{n}"] = mas_diffrax.trajectory(p, form, 10.0**-n)
    return {key: lambda run=run: mas_ode.outcome(p, run()) for key, run in runs.items()}


def library(problem: Problem, effort: Effort) -> dict[tuple[str, str], Callable[[], Any]]:
    """The same of the library."""
    return {
        (name, setting.label): make(problem, setting.value)
        for name, make in mas_runs.SINGLE.items()
        for setting in mas_runs.settings_of(name, effort.steps(problem.law)[name])
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
            row[f"ratio {level:.0e}"] = base / best if best and base else None
        rows.append(row)
    return rows


def cheapest(timings: Sequence[Timing], name: str, level: float) -> float | None:
    """CPU seconds of an engine's cheapest setting with at most this error."""
    return min((t.cpu for t in timings if t.name == name and t.err <= level), default=None)


def single_tables(options: Options, label: str, effort: Effort) -> list[Table]:
    """Single runs of one wire: every setting, and cost at equal error."""
    p = WIRES[label]
    runs = peers(p, "edge", effort)
    if ours(options):
        runs = library(Problem(p), effort) | runs
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
        Table(f"Problem B, {label}: at equal error (rms)", equal_error(timings, "ms", 1e3), RATIO),
    ]


def batch_tables(options: Options, label: str, size: int, effort: Effort) -> list[Table]:
    """A batch around one wire: every setting, and cost at equal error."""
    sets = parameter_sets(WIRES[label], size)
    judge, (simd, march, call) = mas_batches.Judge(sets), mas_runs.BATCH
    settings = {simd: effort.simd_batch, march: effort.march_batch, call: effort.march_batch}
    runs = mas_batches.library(judge, sets, settings) if ours(options) else []
    runs += mas_batches.lsoda(judge, sets, effort.rtols)
    runs += mas_batches.kvaerno(judge, sets, effort.kvaerno_batch)
    timings = measure(runs, options.repeats)
    rows = [
        {"engine": t.name, "setting": t.setting, "sets run": run.per}
        | {"failed": judge.failed[t.name, t.setting], "err": t.err}
        | {"cpu [us]": 1e6 * t.cpu, "spread": t.spread}
        for t, run in zip(timings, runs, strict=True)
    ]
    note = f"Per trajectory; err: worst rms of the first {mas_batches.JUDGED} sets, `failed` where any set is unsolved."
    title = f"Problem B, {label}: batch of {size}"
    return [Table(title, rows, note), Table(f"{title}, at equal error (rms)", equal_error(timings, "us", 1e6), RATIO)]


# ---------------------------------------------------------------- the hybrid law


def good(said: dict[str, Any]) -> bool:
    """Whether an error is within the bar."""
    return said["stress [MPa]"] <= MPA and said["strain [%]"] <= PERCENT


def hybrid_tables(options: Options, effort: Effort) -> list[Table]:
    """`mas-hybrid` on the wire of problem B against the rate law with the barrier form."""
    problem, exact = Problem(Wire(), "mas-hybrid"), reference(Wire(), "barrier")
    runs = peers(Wire(), "barrier", effort)
    if ours(options):
        runs = library(problem, effort) | runs
    timings, judge = timed(runs, exact, options.repeats)
    said = [judge.said[t.name, t.setting] for t in timings]
    rows = [
        {"engine": t.name, "setting": t.setting, **notes, "err": t.err} | {"cpu [ms]": 1e3 * t.cpu, "spread": t.spread}
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
        for base in BASES if best else ():
            tight = [t.cpu for t in timings if (t.name, t.setting) == (base, "rtol 1e-6")]
            loose = [t.cpu for t in fit if t.name == base]
            row: dict[str, Any] = {"engine": name, "cpu [ms]": 1e3 * best, "beside": base}
            row["rtol 1e-6 / this"] = tight[0] / best if tight else None
            row["equal error / this"] = min(loose) / best if loose else None
            row[f">= {TIMES:g}"] = reached(row["rtol 1e-6 / this"])
            rows.append(row)
    note = (
        f"Cheapest settings within {MPA} MPa and {PERCENT} % strain; the first ratio is to the "
        "peer at rtol 1e-6, the second to its cheapest setting within the same error."
    )
    return Table("mas-hybrid: times faster than its stiff equations", rows, note)


def reached(ratio: float | None) -> str:
    """Whether the hybrid law reaches its bar."""
    return "-" if ratio is None else "yes" if ratio >= TIMES else "NO"


@section
def mas(options: Options, effort: Effort = USUAL) -> list[Table]:
    """Problem B and its stiff variant, single and in batches; the hybrid law."""
    tables = [table for label in WIRES for table in single_tables(options, label, effort)]
    sizes = sorted(size for size in options.sizes if size > 1)
    for label, size in [*(("nominal", size) for size in sizes), ("stiff", sizes[0])]:
        tables += batch_tables(options, label, size, effort)
    return tables + hybrid_tables(options, effort)
