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
from benchmarks.equal_error import Contender, equal_error
from benchmarks.inputs import Drive, sine
from benchmarks.problem_a import Wire, rms_error
from benchmarks.problem_b import Wire as RateWire
from benchmarks.references import reference
from benchmarks.report import Table
from benchmarks.sections import Options, gradient
from benchmarks.sections_mas import Effort, library, peers

Row = dict[str, Any]
BASE, LEVELS = "martensite, C", (1e-4, 1e-5)
NAMES = {
    "ours": "martensite, floats",
    "ours-march": BASE,
    "ours-c": "martensite, C, equal steps",
    "lsoda-c": "numbalsoda (LSODA in C)",
    "odeint": "SciPy odeint (LSODA)",
    "lsoda": "SciPy solve_ivp (LSODA)",
    "rk45": "SciPy solve_ivp (RK45)",
    "dop853": "SciPy solve_ivp (DOP853)",
    "radau": "SciPy solve_ivp (Radau)",
    "cvode": "SUNDIALS CVODE (BDF)",
    "diffrax": "diffrax (Tsit5)",
    "diffrax-forward": "diffrax (Tsit5, forward mode)",
}
RATE_NAMES = {
    "ours, march": BASE,
    "ours, C": "martensite, C, equal steps",
    "ours, floats": "martensite, floats",
    "LSODA": "SciPy odeint (LSODA)",
    "Radau": "SciPy solve_ivp (Radau)",
    "CVODE": "SUNDIALS CVODE (BDF)",
    "Kvaerno5": "diffrax (Kvaerno5)",
}
UNITS = re.compile(r"\[(?:n|u|m)?(?:s|mm|MB|us/run|GB)\]|/s\b")


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
    """Engines at equal error."""
    rows = equal_error(contenders, level, repeats, BASE)
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
    names = ["ours-march", "ours-c", "ours", "lsoda-c", "odeint", "lsoda", "rk45", "dop853"]
    names += ["cvode", "diffrax"]
    engines = available(names if choice.quick else [*names, "radau"])
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
