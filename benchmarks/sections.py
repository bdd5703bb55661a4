"""The sections of the benchmark on warm engines, in one process: time and error side by side.

What: a section is a function from the options to tables, entered in `SECTIONS` by its decorator.
A new engine appears in every section that it has a capability for; a new section is one function.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from benchmarks.engines import Engine
from benchmarks.harness import Candidate, Timing, latencies, measure
from benchmarks.inputs import DRIVES, Drive, pulses
from benchmarks.problem_a import Wire, first_sets, parameter_sets, rms_error, thin_wire
from benchmarks.references import batch_reference, gradient_reference, reference
from benchmarks.report import Table

JUDGED = 8  # sets of a batch whose error is measured
LEVELS = (1e-3, 1e-4, 1e-5, 1e-6)
PERIOD = 2e-3  # [s] of the control loop


class Options(NamedTuple):
    """What the command line chose."""

    engines: Sequence[Engine]
    drive: str = "sine"
    repeats: int = 5
    base: str | None = None
    sizes: tuple[int, ...] = (1, 256, 4096)
    calls: int = 18_000
    most: int = 10_000
    budget: float = 60.0

    def case(self) -> tuple[Wire, Drive]:
        """Wire and input of the chosen drive."""
        if self.drive == "pulses":
            return thin_wire(), pulses(thin_wire())
        return Wire(), DRIVES[self.drive]()

    def runners(self, drive: Drive) -> list[Engine]:
        """The engines that make single runs of this input."""
        return [e for e in self.engines if e.single and (drive.edges or not e.only_edges)]


Section = Callable[[Options], Iterable[Table]]
Some = TypeVar("Some", bound=Callable[..., Iterable[Table]])
SECTIONS: dict[str, Section] = {}


def section(make: Some) -> Some:
    """Enter a section under the name of its function."""
    SECTIONS[make.__name__] = make
    return make


def rows_of(timings: Sequence[Timing], unit: str, factor: float) -> list[dict[str, Any]]:
    """Printed rows with the times in `unit`."""
    return [
        {
            "engine": t.name,
            "setting": t.setting,
            "err": t.err,
            f"cpu [{unit}]": t.cpu * factor,
            f"wall [{unit}]": t.wall * factor,
            "spread": t.spread,
            "ratio": t.ratio,
        }
        for t in timings
    ]


def single_candidate(engine: Engine, label: str, p: Wire, drive: Drive) -> Candidate:
    """A run of one engine at one setting."""
    assert engine.single is not None
    exact = reference(engine.rule, p, drive)
    run = engine.single(p, drive, engine.settings[label])
    return Candidate(engine.name, run, lambda x: rms_error(x, exact), setting=label)


@section
def single(options: Options) -> list[Table]:
    """One warm run of every engine at its usual setting."""
    p, drive = options.case()
    able = options.runners(drive)
    runs = [single_candidate(e, e.usual, p, drive) for e in able]
    timings = measure(runs, options.repeats, options.base)
    rows = rows_of(timings, "ms", 1e3)
    for row, engine in zip(rows, able, strict=True):
        row["rule"] = engine.rule
    return [Table(f"Single run, {drive.name}, {drive.duration:g} s", rows)]


@section
def precision(options: Options) -> list[Table]:
    """Every setting of every engine, and the cheapest that reaches each error."""
    p, drive = options.case()
    able = options.runners(drive)
    runs = [single_candidate(e, label, p, drive) for e in able for label in e.settings]
    timings = measure(runs, options.repeats, options.base)
    return [
        Table(f"Work and precision, {drive.name}", rows_of(timings, "ms", 1e3)),
        cheapest(timings, f"Cheapest setting that reaches an error, {drive.name}", "ms", 1e3),
    ]


def cheapest(timings: Sequence[Timing], title: str, unit: str, factor: float) -> Table:
    """CPU time of the cheapest setting of each engine that reaches each error."""
    rows = []
    for name in dict.fromkeys(t.name for t in timings):
        row: dict[str, Any] = {"engine": name}
        for target in LEVELS:
            good = [t.cpu for t in timings if t.name == name and t.err <= target]
            row[f"to {target:.0e} [{unit}]"] = factor * min(good) if good else None
        rows.append(row)
    return Table(title, rows)


def batch_candidate(engine: Engine, size: int, p: Wire, drive: Drive, label: str | None = None) -> Candidate:
    """A batch of one engine, cut to what it can take, at its usual setting or another."""
    label = label or engine.usual
    assert engine.batch is not None
    count = min(size, engine.batch_limit)
    sets = first_sets(parameter_sets(size)._replace(**other_fields(p)), count)
    exact = batch_reference(engine.rule, sets, drive, min(count, JUDGED))
    run = engine.batch(sets, drive, engine.settings[label])
    return Candidate(engine.name, run, lambda x: worst(x, exact), count, label)


def other_fields(p: Wire) -> dict[str, float]:
    """The fields of a wire that parameter sets do not vary."""
    return {name: value for name, value in p._asdict().items() if name in Wire._fields[10:]}


def worst(x: Any, exact: list[Any]) -> float:
    """Largest error over the judged sets."""
    return max(rms_error(x[i], exact[i]) for i in range(len(exact)))


@section
def batch(options: Options) -> list[Table]:
    """Trajectories of many parameter sets."""
    p, drive = options.case()
    tables = []
    for size in options.sizes:
        runs = [batch_candidate(e, size, p, drive) for e in options.engines if e.batch]
        rows = rows_of(measure(runs, options.repeats, options.base), "us", 1e6)
        rows = [{**row, "sets run": run.per} for row, run in zip(rows, runs, strict=True)]
        note = f"Per trajectory; err is the worst of the first {JUDGED} sets."
        tables.append(Table(f"Batch of {size}, {drive.name}", rows, note))
    return tables


@section
def batch_precision(options: Options) -> list[Table]:
    """Every setting of every engine in the middle batch size: cost at equal error."""
    p, drive = options.case()
    size = sorted(options.sizes)[len(options.sizes) // 2]
    able = [e for e in options.engines if e.batch]
    runs = [batch_candidate(e, size, p, drive, label) for e in able for label in e.settings]
    timings = measure(runs, options.repeats, options.base)
    note = f"Per trajectory; err is the worst of the first {JUDGED} sets."
    title = f"Batch of {size}, cheapest setting that reaches an error, {drive.name}"
    return [
        Table(f"Batch of {size}, work and precision", rows_of(timings, "us", 1e6), note),
        cheapest(timings, title, "us", 1e6),
    ]


def gradient_candidate(engine: Engine, p: Wire, drive: Drive) -> Candidate:
    """The gradient of one engine, judged against the converged one of its rule."""
    assert engine.gradient is not None
    exact = gradient_reference(engine.rule, p, drive)

    def error(found: Any) -> float:
        return float(np.linalg.norm(np.asarray(found) - exact) / np.linalg.norm(exact))

    run = engine.gradient(p, drive, engine.settings[engine.usual])
    return Candidate(engine.name, run, error, setting=engine.usual)


@section
def gradient(options: Options) -> list[Table]:
    """dJ/dq, ten parameters."""
    p, drive = options.case()
    runs = [gradient_candidate(e, p, drive) for e in options.engines if e.gradient]
    rows = rows_of(measure(runs, options.repeats, options.base), "ms", 1e3)
    note = "err: norm of the difference to the converged gradient of the same rule, relative."
    return [Table(f"Gradient of ten parameters, {drive.name}", rows, note)]


@section
def latency(options: Options) -> list[Table]:
    """Single steps of a control loop, the input changed before each."""
    rows = []
    for engine in options.engines:
        if engine.step is None:
            continue
        state, advance = engine.step(Wire(), PERIOD)
        holder = [state]

        def call(i: int, advance: Any = advance, holder: list[Any] = holder) -> None:
            holder[0] = advance(holder[0], 9.0 if i % 5000 < 2500 else 1.0)

        times = latencies(call, options.calls)
        at = {"median": 0.5, "p99": 0.99, "p99.9": 0.999}
        row: dict[str, Any] = {"engine": engine.name}
        row |= {f"{k} [us]": 1e6 * times[int(q * len(times))] for k, q in at.items()}
        rows.append({**row, "over 2 ms": sum(t > PERIOD for t in times)})
    return [Table(f"Latency of one step of {1e3 * PERIOD:g} ms (wall)", rows)]
