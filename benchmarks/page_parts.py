"""The parts of the benchmark page: sections with a few engines each, reduced to ratios.

What: a part is a function from `Choice` to tables of ratios, entered in `PARTS`. It makes runs;
nothing of the page's text is here. Times leave with the tables of the sections: what stays is
without a unit, so that the numbers of two machines can be laid side by side.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

from benchmarks import mas_batches, mas_runs, sections_realtime, sections_sweep, sections_throughput
from benchmarks.engines import Engine, available
from benchmarks.equal_error import Contender, Made, equal_error
from benchmarks.inputs import Drive, sine
from benchmarks.problem_a import Wire, first_sets, parameter_sets, rms_error
from benchmarks.problem_b import Wire as RateWire
from benchmarks.references import batch_reference, reference
from benchmarks.report import Table
from benchmarks.sections import Options, gradient
from benchmarks.sections_mas import Effort, library, peers

Row = dict[str, Any]
LEVELS = (1e-4, 1e-5)
COMPILED, ODEINT = "numbalsoda (LSODA in C)", "SciPy odeint (LSODA)"
CALL, MARCH, FLOATS = "martensite, `simulate`", "martensite, C alone", "martensite, floats"
NAMES = {
    "lsoda-c": COMPILED,
    "odeint": ODEINT,
    "ours-call": CALL,
    "ours-march": MARCH,
    "ours-c": "martensite, C, equal steps",
    "ours": FLOATS,
    "lsoda": "SciPy solve_ivp (LSODA)",
    "rk45": "SciPy solve_ivp (RK45)",
    "dop853": "SciPy solve_ivp (DOP853)",
    "radau": "SciPy solve_ivp (Radau)",
    "cvode": "SUNDIALS CVODE (BDF)",
    "diffrax": "diffrax (Tsit5)",
    "diffrax-forward": "diffrax (Tsit5, forward mode)",
}
RATE_NAMES = {
    "LSODA in C": COMPILED,
    "LSODA": ODEINT,
    "ours, call": CALL,
    "ours, march": MARCH,
    "ours, C": "martensite, C, equal steps",
    "ours, floats": FLOATS,
    "Radau": "SciPy solve_ivp (Radau)",
    "CVODE": "SUNDIALS CVODE (BDF)",
    "Kvaerno5": "diffrax (Kvaerno5)",
}
UNITS = re.compile(r"\[(?:n|u|m)?(?:s|mm|MB|us/run|GB)\]|/s\b")


BATCHED = ("lsoda-c", "odeint", "ours-call", "ours-march")
RATE_BATCHED = ("LSODA in C", "LSODA", "ours, call", "ours, march")
JUDGED, FEW = 4, 16
"""Runs of a batch that are compared with references, and runs of a solver that makes them one after another."""


class Choice(NamedTuple):
    """How much is run."""

    quick: bool = False
    repeats: int = 5
    sizes: Sequence[int] = (1, 64, 1024, 4096)
    most: int = 1_000_000
    budget: float = 240.0

    def levels(self) -> Sequence[float]:
        """Errors at which engines are compared."""
        return LEVELS[:1] if self.quick else LEVELS


Part = Callable[[Choice], list[Table]]
PARTS: dict[str, Part] = {}


def part(make: Part) -> Part:
    """Enter a part under the name of its function."""
    PARTS[make.__name__] = make
    return make


def without_units(row: Row) -> Row:
    """A row without its absolute times, rates and memory."""
    return {name: value for name, value in row.items() if not UNITS.search(name)}


def table_at(level: float, contenders: Sequence[Contender], repeats: int) -> Table:
    """Engines at equal error; the first one is the base."""
    rows = equal_error(contenders, level, repeats, contenders[0].name)
    return Table(f"Error of at most {level:.0e}", rows)


# ---------------------------------------------------------------- single runs


def wire_contender(engine: Engine, p: Wire, drive: Drive) -> Contender:
    """An engine on problem A."""
    assert engine.single is not None
    exact, make = reference(engine.rule, p, drive), partial(engine.single, p, drive)
    settings = {label: lambda setting=setting: make(setting) for label, setting in engine.settings.items()}
    return Contender(NAMES[engine.name], settings, lambda x: rms_error(x, exact))


@part
def wire(choice: Choice) -> list[Table]:
    """Single runs of problem A."""
    names = [name for name in NAMES if name != "diffrax-forward" and not (choice.quick and name == "radau")]
    engines = available(names)
    contenders = [wire_contender(e, Wire(), sine()) for e in engines]
    return [table_at(level, contenders, choice.repeats) for level in choice.levels()]


@part
def rates(choice: Choice) -> list[Table]:
    """Single runs of problem B."""
    effort = Effort(kvaerno=() if choice.quick else (4, 5, 6))
    runs = library(mas_runs.Problem(RateWire()), effort) | peers(RateWire(), "edge", effort)
    exact = mas_batches.reference(RateWire(), "edge")[0]

    def error(found: Any) -> float:
        return mas_batches.errors(found[0], exact)[0]

    settings: dict[str, dict[str, Any]] = {}
    for (engine, label), run in runs.items():
        settings.setdefault(RATE_NAMES[engine], {})[label] = lambda run=run: run
    order = [name for name in RATE_NAMES.values() if name in settings]
    contenders = [Contender(name, settings[name], error) for name in order]
    return [table_at(level, contenders, choice.repeats) for level in choice.levels()]


# ---------------------------------------------------------------- batches


def wire_batch(engine: Engine, sets: Wire, count: int) -> Contender:
    """An engine on the first `count` wires of a batch of problem A; the first ones are judged."""
    assert engine.batch is not None
    some, make = first_sets(sets, count), engine.batch
    exact = batch_reference(engine.rule, sets, sine(), JUDGED)
    settings = {
        label: lambda setting=setting: make(some, sine(), setting) for label, setting in engine.settings.items()
    }
    return Contender(NAMES[engine.name], settings, lambda x: max(map(rms_error, x[:JUDGED], exact)), count)


def rate_batch(name: str, sets: list[RateWire], count: int) -> Contender:
    """An engine on the first `count` wires of a batch of problem B; the first ones are judged."""
    some, effort = sets[:count], Effort()
    exact = [mas_batches.reference(one, "edge")[0] for one in sets[:JUDGED]]
    settings: dict[str, Made] = {}
    if make := mas_runs.BATCH.get(name):
        for setting in mas_runs.settings_of(name, effort.march):
            settings[setting.label] = partial(make, mas_runs.Problem(some[0]), some, setting.value)
    else:
        solve = mas_batches.lsoda_c if name == "LSODA in C" else mas_batches.odeint
        settings = {f"rtol 1e-{n}": partial(solve, some, 10.0**-n) for n in effort.rtols}

    def error(found: Any) -> float:
        return max(mas_batches.errors(x, y)[0] for x, y in zip(found, exact, strict=False))

    return Contender(RATE_NAMES[name], settings, error, count)


@part
def calls(choice: Choice) -> list[Table]:
    """Batches as users call them, at equal error."""
    count = 64 if choice.quick else 256
    sets, rate_sets = parameter_sets(count), mas_runs.parameter_sets(RateWire(), count)
    names = [name for name in RATE_BATCHED if name != "LSODA in C" or mas_batches.LSODA_C]
    wires = [wire_batch(e, sets, count if e.name.startswith("ours") else FEW) for e in available(BATCHED)]
    rates = [rate_batch(name, rate_sets, count if name.startswith("ours") else FEW) for name in names]
    tables = []
    for level in choice.levels():
        for problem, contenders in (("A", wires), ("B", rates)):
            table = table_at(level, contenders, choice.repeats)
            tables.append(table._replace(title=f"Problem {problem}, batch of {count}. {table.title}"))
    return tables


@part
def batches(choice: Choice) -> list[Table]:
    """Many runs at once: throughput, scaling, and the limits of the processor."""
    effort = sections_throughput.USUAL._replace(scaling=(1_000, 10_000, 100_000, 1_000_000))
    if choice.quick:
        effort = effort._replace(laws=effort.laws[:1], scaling=(1_000, 10_000))
    options = Options([], repeats=min(choice.repeats, 3), sizes=tuple(choice.sizes))
    return rated(sections_throughput.throughput(options, effort))


def rated(tables: Sequence[Table]) -> list[Table]:
    """Tables of the section without units; rates and memory as shares of one row."""
    wires = [t.rows for t in tables if "coupled wire" in t.title and "runs/s (wall)" in t.rows[0]]
    most = max((rows[0] for rows in wires), key=lambda row: row["runs"], default=None)
    found: list[Table] = []
    for table in tables:
        rates = "runs/s (wall)" in table.rows[0]
        base = most if table.rows in wires else table.rows[0]
        rows = [without_units(row) for row in table.rows]
        for row, raw in zip(rows, table.rows, strict=True):
            if rates and base:
                row["rate"] = raw["runs/s (wall)"] / base["runs/s (wall)"]
            if "peak [MB]" in raw:
                row["memory"] = raw["peak [MB]"] / table.rows[0]["peak [MB]"]
        found.append(Table(table.title, rows))
    return found


@part
def sweep(choice: Choice) -> list[Table]:
    """A sweep into a store, from one run to a million."""
    most = min(choice.most, 10_000) if choice.quick else choice.most
    options = Options([], repeats=min(choice.repeats, 3), most=most, budget=choice.budget)
    (table,) = sections_sweep.sweep(options)
    rows = [without_units(row) for row in table.rows]
    absent = [n for n in sections_sweep.counts(most) if n > rows[-1]["runs"]]
    note = f"Left out for want of time: {absent[0]:,} runs and more." if absent else ""
    return [Table(table.title, rows, note)]


# ---------------------------------------------------------------- the rest


@part
def slopes(choice: Choice) -> list[Table]:
    """The gradient of ten parameters."""
    names = ["ours-c", "odeint", "cvode"] if choice.quick else list(NAMES)
    engines = [e for e in available(names) if e.gradient and e.name != "diffrax"]
    (table,) = gradient(Options(engines, repeats=min(choice.repeats, 3), base="ours-c"))
    rows = [without_units({**row, "engine": NAMES[row["engine"]]}) for row in table.rows]
    return [Table(table.title, rows)]


@part
def control(choice: Choice) -> list[Table]:
    """One step of a control loop, as a share of its period."""
    (table,) = sections_realtime.realtime(Options([], calls=2_000 if choice.quick else 18_000))
    columns = {"median": "median [us]", "p99": "p99 [us]", "p99.9": "p99.9 [us]"}
    period = 1e6 * sections_realtime.PERIOD
    rows = [
        {"step": row["step"], **{short: row[long] / period for short, long in columns.items()}} for row in table.rows
    ]
    return [Table(table.title, rows)]
