"""Tracing of a system to a program over flat states, cached by structure.

The program is independent of parameter values. A different law, option or mechanism needs a new trace.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import Any, NamedTuple, cast

from martensite.actuators.assembly import PROFILES, AbstractSystem, Feed
from martensite.actuators.assembly.base import AbstractAssembly
from martensite.actuators.assembly.ledger import ACCOUNTS
from martensite.actuators.elements.base import MaterialPoint
from martensite.base.parameters import StructureKey, values_at
from martensite.base.remember_results import remember
from martensite.kernels.compute_once import cache_answers
from martensite.kernels.graph import Expr
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.kernels.program import Program
from martensite.physics.laws.coupling import StepReport
from martensite.signals.moments import Moments
from martensite.simulate.forks import LawFork
from martensite.simulate.ledger import EMPTY, Book

REPORT = StepReport._fields[:2]
"""Names of the reports of a step under constant signals."""
ENVELOPE = ("hottest", "stress", "strain")
"""Outputs of an element that define the envelope."""
FED = (*Moments._fields, "owed")
"""Names of the inputs of a step from a heating drive."""
Functions = Mapping[str, Callable[..., tuple[float, ...]]]


@dataclass(frozen=True, eq=False)
class CompiledSystem:
    """Traced system with the functions `init`, `step` and `observe` over flat states."""

    program: Program
    paths: tuple[str, ...]
    """Parameter paths in program order."""
    size: int
    """Number of state variables."""
    drives: int
    """Number of drive signals."""
    outputs: tuple[str, ...]
    """Outputs of the system, then the profile of its element: `cell_temperature[0]`, …"""
    report: tuple[str, ...] = REPORT

    def values(self, system: AbstractSystem) -> list[float]:
        """Return the parameter values of a system of this structure, in program order."""
        return values_at(system, self.paths)


@remember
def name_outputs(system: AbstractSystem) -> tuple[str, ...]:
    """Return the names of the outputs of a system, in order."""
    return tuple(system.outputs())


def compile_system(system: AbstractSystem) -> CompiledSystem:
    """Return the traced program of a system, cached by structure."""
    return _compile_keyed(StructureKey(system))


class LawPoint(NamedTuple):
    """Position of a rate-independent law among the outputs."""

    fraction: int
    """Index of the judged output with its martensite fraction."""
    weight: float
    """Weight of the law in that output."""
    size: int
    """Number of values at the point: temperature, stress, two fractions, then kinks of the law."""


@dataclass(frozen=True, eq=False)
class CompiledMarch(CompiledSystem):
    """System traced for time integration; `step` takes drive inputs.

    The functions return:
    - `judge`: judged outputs, envelope outputs and the heat of the elements.
    - `points`: temperature, stress and fractions at rate-independent laws.
    - `forks`: branches that these laws may forget.
    - `entries`: energies for the ledgers.
    - `flows`: power into and, if known, out of the drives.
    """

    widths: tuple[int, ...] = ()
    """Number of inputs of `step` by drive: all of `FED`, or one."""
    convergence_scales: tuple[tuple[str, float], ...] = ()
    """Judged outputs with their smallest relevant ranges."""
    envelope: tuple[tuple[str, str], ...] = ()
    """Port and output of each envelope bound."""
    heated: tuple[int, ...] = ()
    """Drives of elements with a known heat content."""
    points: tuple[LawPoint, ...] = ()
    """Layout of the values that `points` returns."""
    forks: tuple[LawFork, ...] = ()
    """Layout of the values that `forks` returns."""
    book: Book = EMPTY
    """Layout of the values that `entries` returns."""
    rates: tuple[int, ...] = ()
    """Indices of states that only serve as initial guesses of a solve."""

    follows: bool = False
    """True if a signal prescribes a state without rates or inertia, so that the step error misses its shape."""

    @property
    def order(self) -> int:
        """Return the order of a step with error control: 4 where laws give rates, else 2."""
        functions = self.program.functions
        return 4 if "rosenbrock" in functions else 5 if "surface" in functions else 2

    @property
    def inputs(self) -> int:
        """Return the number of drive inputs of `step`."""
        return sum(self.widths)

    def signals_in_step(self) -> list[int]:
        """Return the indices of all drive signals, or their means, among the inputs of `step`."""
        return [sum(self.widths[:k]) for k in range(self.drives)]

    def asks_for_signals(self, name: str, outputs: Sequence[int] | None = None) -> bool:
        """Return whether outputs (all if None) of a function of state and signals depend on signals."""
        function = self.program.functions[name]
        places = range(len(function.outputs)) if outputs is None else outputs
        nodes = [function.outputs[i] for i in places]
        return self.program.needs(nodes, function.inputs[self.size :])

    @cached_property
    def judged(self) -> list[int]:
        """Return the indices of judged outputs."""
        return [self.outputs.index(name) for name, _ in self.convergence_scales]

    @cached_property
    def swinging(self) -> tuple[bool, ...]:
        """Return whether each output depends on the signals."""
        return tuple(self.asks_for_signals("observe", [place]) for place in range(len(self.outputs)))

    def states_observed(self, outputs: Sequence[int]) -> list[int]:
        """Return 1 for every state variable that affects the outputs, else 0."""
        key = tuple(outputs)
        if key not in self._observed:
            function = self.program.functions["observe"]
            nodes = [function.outputs[i] for i in key]
            self._observed[key] = list(map(int, self.program.list_needed(nodes, function.inputs[: self.size])))
        return self._observed[key]

    @cached_property
    def idle(self) -> list[Any]:
        """Return the arrays of single runs in C that the next runs use again."""
        return []

    @cached_property
    def _observed(self) -> dict[tuple[int, ...], list[int]]:
        """Return the cache of `states_observed`."""
        return {}


@remember
def compile_march(system: AbstractSystem) -> CompiledMarch:
    """Trace a system with drives that are integrated over every step."""
    return _compile_march(StructureKey(system))


@remember
def list_values(system: AbstractSystem) -> tuple[float, ...]:
    """Return the parameter values of a system in the order of `compile_march`."""
    return tuple(compile_march(system).values(system))


def bind_system(system: AbstractSystem) -> tuple[Functions, int]:
    """Return the functions of a system on floats with bound parameters, and the number of states."""
    compiled = compile_system(system)
    return compiled.program.bind_floats(*compiled.values(system)), compiled.size


def bind_march(system: AbstractSystem) -> tuple[Functions, int]:
    """Return the bound functions of a system with integrated drives."""
    compiled = compile_march(system)
    return compiled.program.bind_floats(*compiled.values(system)), compiled.size


def feed_step(moments: Moments, owed: float = 0.0) -> tuple[float, ...]:
    """Return the inputs of a step from the drive moments."""
    return (*moments, owed)


@cache_answers(64)
def _compile_keyed(keyed: StructureKey[AbstractSystem]) -> CompiledSystem:
    trace = _Trace(keyed)
    trace.add_step([None] * trace.drives, len(REPORT))
    return CompiledSystem(trace.program, trace.paths, trace.size, trace.drives, trace.outputs)


@cache_answers(64)
def _compile_march(keyed: StructureKey[AbstractSystem]) -> CompiledMarch:
    trace, system = _Trace(keyed), keyed.part
    feeds = [not (one.at_end or system.sample_time()) for one in system.drives()]
    trace.add_step(feeds, len(StepReport._fields))
    judged = tuple(system.convergence_scales().items())
    envelope = tuple((port, name) for port in system.actuators() for name in ENVELOPE)
    wanted = [*(name for name, _ in judged), *(system.label(*pair) for pair in envelope)]
    return CompiledMarch(
        trace.program,
        trace.paths,
        trace.size,
        trace.drives,
        trace.outputs,
        StepReport._fields,
        widths=tuple(len(FED) if feed else 1 for feed in feeds),
        convergence_scales=judged,
        envelope=envelope,
        heated=trace.add_judge(wanted, feeds),
        points=trace.add_points(judged),
        forks=trace.add_forks(judged),
        book=trace.add_entries(),
        rates=trace.rates(),
        follows=False in feeds and not system.exchanges() and not math.isfinite(system.mechanism.first_step()),
    )


class _Trace:
    """Kernels of a system, traced over flat states."""

    def __init__(self, keyed: StructureKey[AbstractSystem]) -> None:
        self.program = Program()
        self.paths = tuple(leaf.path for leaf in keyed.part.leaves())
        numbers = {path: self.program.parameter(path) for path in self.paths}
        self.system = keyed.part.rebuilt(numbers)
        self.drives = len(self.system.drives())
        self.signals = [f"u{i}" for i in range(self.drives)]
        self.program.add("init", self.signals, self._init)
        self.size = len(flatten_numbers(self.shape.example))
        self.names = [f"s{i}" for i in range(self.size)]
        self.program.add("observe", [*self.names, *self.signals], self._observe)
        profile = self.system.profile(self.shape.example)
        pairs = zip(PROFILES, profile, strict=False)
        along = (f"{name}[{i}]" for name, column in pairs for i in range(len(column)))
        self.outputs = (*keyed.part.outputs(), *along)

    def add_step(self, feeds: Sequence[bool | None], reports: int) -> None:
        """Add the step under signals or drive inputs, with the first values of its report."""
        parts = [FED if feed else ("",) for feed in feeds]
        inputs = [
            f"{signal}_{name}" if name else signal
            for signal, names in zip(self.signals, parts, strict=True)
            for name in names
        ]

        def brought(numbers: Sequence[Any]) -> tuple[Any, list[Any]]:
            """Return the state and the drive inputs."""
            rest = iter(numbers[self.size :])
            rows = [[next(rest) for _ in names] for names in parts]
            drives = [Feed(Moments(*row[:-1]), row[-1]) if row[1:] else row[0] for row in rows]
            return self.shape.rebuild(numbers[: self.size]), drives

        def step(xp: Any, *arguments: Any) -> list[Any]:
            *numbers, dt = arguments
            state, drives = brought(numbers)
            after, report = self.system.step(xp, state, *drives, dt=dt)
            return flatten_numbers(after) + flatten_numbers(report)[:reports]

        def flows(xp: Any, *numbers: Any) -> list[Any]:
            state, drives = brought(numbers)
            lost = self.system.losses(xp, state, *drives)
            return [self.system.flows(xp, state, *drives), *([] if lost is None else [lost])]

        def rosenbrock(xp: Any, *arguments: Any) -> list[Any]:
            *numbers, dt = arguments
            state, drives = brought(numbers)
            return flatten_numbers(self.system.step_rosenbrock(xp, state, *drives, dt=dt))

        assembly = cast(AbstractAssembly, self.system)

        def surface(xp: Any, *arguments: Any) -> list[Any]:
            *numbers, dt = arguments
            count = self.size + len(inputs)
            state, first = brought(numbers[:count])
            _, last = brought([*numbers[: self.size], *numbers[count:]])
            return flatten_numbers(assembly.step_on_surface(xp, state, first, last, dt))

        def events(xp: Any, *numbers: Any) -> list[Any]:
            return assembly.find_events(xp, self.shape.rebuild(numbers[: self.size]), *numbers[self.size :])

        self.program.add("step", [*self.names, *inputs, "dt"], step)
        if reports > len(REPORT) and all(feeds) and self.system.has_surface():
            later = [f"{name}_later" for name in inputs]
            self.program.add("surface", [*self.names, *inputs, *later, "dt"], surface)
            self.program.add("events", [*self.names, "temperature", "stress"], events)
        if reports > len(REPORT) and self.system.exchanges():
            self.program.add("rosenbrock", [*self.names, *inputs, "dt"], rosenbrock)
        if reports > len(REPORT):
            self.program.add("flows", [*self.names, *inputs], flows)
        step_function = self.program.functions["step"]
        residual = step_function.outputs[: self.size + 1]
        self.program.functions["solve"] = replace(step_function, name="solve", outputs=residual)
        self.program.functions["ripple"] = replace(step_function, name="ripple", outputs=step_function.outputs[-1:])

    def add_judge(self, outputs: Sequence[str], feeds: Sequence[bool]) -> tuple[int, ...]:
        """Add the judged outputs and the heat of fed elements; return the drives with known heat."""
        places = [self.outputs.index(name) for name in outputs]
        heat_drives: list[int] = []

        def judge(xp: Any, *arguments: Any) -> list[Any]:
            state = self.shape.rebuild(arguments[: self.size])
            observations = self.system.observe(xp, state, *arguments[self.size :])
            contents = enumerate(self.system.heat_contents(xp, state))
            heats = {place: heat for place, heat in contents if heat is not None and feeds[place]}
            heat_drives[:] = heats
            return [*(observations[place] for place in places), *heats.values()]

        self.program.add("judge", [*self.names, *self.signals], judge)
        return tuple(heat_drives)

    def add_entries(self) -> Book:
        """Add the function for the energies of a state under signals."""
        books: list[Book] = []

        def entries(xp: Any, *arguments: Any) -> list[Any]:
            state = self.shape.rebuild(arguments[: self.size])
            entry = self.system.entries(xp, state, *arguments[self.size :])
            stores = {name: one for name, one in entry.energies.items() if isinstance(one, Expr)}
            accounts = [ACCOUNTS.index(name) for name, _ in entry.efforts]
            books.append(
                Book(
                    tuple(map(ACCOUNTS.index, stores)),
                    tuple(accounts),
                    entry.has_heat_balance,
                    entry.has_work_balance,
                    entry.unknown,
                )
            )
            numbers = [*stores.values(), *flatten_numbers(tuple(effort for _, effort in entry.efforts))]
            return [*numbers, *([entry.lost] if entry.has_heat_balance else [])]

        self.program.add("entries", [*self.names, *self.signals], entries)
        return books[-1]

    def add_points(self, judged: Sequence[tuple[str, float]]) -> tuple[LawPoint, ...]:
        """Add the points of rate-independent laws: temperature, stress and fractions."""
        places = list[LawPoint]()
        names = [name for name, _ in judged]

        def points(xp: Any, *state: Any) -> list[Any]:
            point_rows = list(self._list_points(xp, state))
            numbers = [flatten_numbers(point._replace(forks=())) for *_, point in point_rows]
            rows = zip(point_rows, numbers, strict=True)
            places[:] = [
                LawPoint(names.index(self.system.label(port, "martensite_fraction")), weight, len(own))
                for (port, weight, _), own in rows
            ]
            return list(chain.from_iterable(numbers))

        self.program.add("points", self.names, points)
        return tuple(places)

    def add_forks(self, judged: Sequence[tuple[str, float]]) -> tuple[LawFork, ...]:
        """Add the branches that rate-independent laws may forget."""
        places = list[LawFork]()
        names = [name for name, _ in judged]

        def forks(xp: Any, *state: Any) -> list[Any]:
            fork_rows = [(port, weight, one) for port, weight, p in self._list_points(xp, state) for one in p.forks]
            places.clear()
            for port, weight, _ in fork_rows:
                columns = ("martensite_fraction", "temperature", "stress")
                fraction, temperature, stress = (names.index(self.system.label(port, name)) for name in columns)
                places.append(LawFork(fraction, temperature, stress, weight))
            return [number for *_, one in fork_rows for number in one]

        self.program.add("forks", self.names, forks)
        return tuple(places)

    def _list_points(self, xp: Any, state: Sequence[Any]) -> Iterator[tuple[str, float, MaterialPoint]]:
        """Yield the port, the weight in its element, and the values of every point."""
        rows = self.system.points(xp, self.shape.rebuild(state))
        for port, row in zip(self.system.actuators(), rows, strict=False):
            yield from ((port, 1.0 / len(row), point) for point in row)

    def rates(self) -> tuple[int, ...]:
        """Return the indices of states that only serve as initial guesses of a solve."""
        places = [float(i) for i in range(self.size)]
        return tuple(int(i) for i in self.system.rates(self.shape.rebuild(places)))

    def _init(self, xp: Any, *drives: Any) -> list[Any]:
        state = self.system.init(xp, *drives)
        self.shape = NestedShape(state)
        return flatten_numbers(state)

    def _observe(self, xp: Any, *arguments: Any) -> list[Any]:
        state, drives = self.shape.rebuild(arguments[: self.size]), arguments[self.size :]
        along = [number for column in self.system.profile(state) for number in column]
        return [*self.system.observe(xp, state, *drives), *along]
