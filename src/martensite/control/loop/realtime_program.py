"""A loop without its plant as a program: kernels of a first and of any other sample."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from martensite.base.parameters import Keyed
from martensite.control.loop import period
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import AGE, list_references
from martensite.control.loop.parts import Controlling, Inputs, Named, ObserverState
from martensite.control.observers.base import ESTIMATED
from martensite.kernels.compiled_program import CompiledProgram
from martensite.kernels.compute_once import cache_answers
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers
from martensite.kernels.program import Program


class LoopState(NamedTuple):
    """State of a loop without its plant."""

    observers: tuple[ObserverState, ...]
    controllers: tuple[Controlling, ...]
    supervisor: tuple[Scalar, ...]
    alarm: Scalar
    signals: tuple[Scalar, ...]
    """Of all drives of the plant, as the supervisor lets them pass."""


def list_reads(bench: Bench) -> tuple[str, ...]:
    """Names of the readings that the parts of a bench need from sensors."""
    parts: list[Any] = [*bench.observers.members().values(), *bench.controllers.members().values()]
    parts += [] if bench.supervisor is None else [bench.supervisor]
    names = [name for one in parts for name in one.reads()]
    measured = [name for name in names if not name.startswith(ESTIMATED)]
    return tuple(dict.fromkeys(name.removesuffix(AGE) for name in measured))


# ---------------------------------------------------------------- kernels


def _begin_sample(bench: Bench, xp: Namespace, known: Named, given: Inputs) -> LoopState:
    """The first sample, as at the start of a bench."""
    observers, controllers, held, known = period.begin_loop(bench, xp, known, given)
    return _judge_sample(bench, xp, LoopState(observers, controllers, held, 0.0, ()), known, given)


def _continue_sample(bench: Bench, xp: Namespace, before: LoopState, known: Named, given: Inputs) -> LoopState:
    """Another sample, a period after the one before."""
    signals = dict(zip(_list_drives(bench), before.signals, strict=True))
    observers = period.update_observers(bench, xp, before.observers, known, signals)
    known = known | period.collect_estimates(bench, observers)
    controllers = period.update_controllers(bench, xp, before.controllers, known, given)
    after = before._replace(observers=observers, controllers=controllers)
    return _judge_sample(bench, xp, after, known, given)


def _judge_sample(bench: Bench, xp: Namespace, loop: LoopState, known: Named, given: Inputs) -> LoopState:
    """With the signals that the supervisor lets pass."""
    ordered = period.collect_wanted(bench, loop.controllers, given)
    said = period.judge_signals(bench, xp, loop.supervisor, ordered, known)
    signals = tuple(said.signals[name] for name in ordered)
    return loop._replace(supervisor=tuple(said.memory), alarm=said.alarm, signals=signals)


def _list_drives(bench: Bench) -> list[str]:
    return [drive.name for drive in bench.plant.drives()]


# ---------------------------------------------------------------- programs


@dataclass(frozen=True, eq=False)
class TracedLoop:
    """A traced loop; functions `begin` and `step` over flat states."""

    program: Program
    paths: tuple[str, ...]
    """Parameter paths in the order in which the program takes them."""
    shape: NestedShape
    size: int
    """Numbers of the state."""
    inputs: int
    """Readings, their ages, references, signals that no controller has."""


def trace_loop(bench: Bench) -> TracedLoop:
    """Trace the loop of a bench, or return that of an earlier one of the same structure."""
    return _trace_keyed(Keyed(bench))


@cache_answers(32)
def _trace_keyed(keyed: Keyed[Bench]) -> TracedLoop:
    """Kernels of a first and of another sample as a program over flat states."""
    program = Program()
    paths = tuple(leaf.path for leaf in keyed.part.leaves())
    bench = keyed.part.rebuilt({path: program.parameter(path) for path in paths})
    names, free = (list_reads(bench), [n for n in _list_drives(bench) if n not in bench.controllers.members()])
    signals = [*names, *(name + AGE for name in names), *list_references(bench), *free]
    labels = [f"i{i}" for i in range(len(signals))]
    found: list[NestedShape] = []

    def sorted_out(numbers: Sequence[Scalar]) -> tuple[Named, Inputs]:
        split, end = 2 * len(names), len(signals) - len(free)
        others = dict(zip(free, numbers[end:], strict=True))
        known = dict(zip(signals[:split], numbers[:split], strict=True))
        return known, Inputs(tuple(numbers[split:end]), others, ())

    def begin(xp: Any, *numbers: Any) -> list[Any]:
        loop = _begin_sample(bench, xp, *sorted_out(numbers))
        found.append(NestedShape(loop))
        return flatten_numbers(loop)

    def step(xp: Any, *numbers: Any) -> list[Any]:
        before = found[0].rebuild(numbers[:size])
        return flatten_numbers(_continue_sample(bench, xp, before, *sorted_out(numbers[size:])))

    program.add("begin", labels, begin)
    size = len(flatten_numbers(found[0].example))
    program.add("step", [*(f"s{i}" for i in range(size)), *labels], step)
    return TracedLoop(program, paths, found[0], size, len(labels))


class CompiledLoop:
    """One loop in C."""

    def __init__(self, traced: TracedLoop, values: Sequence[float]) -> None:
        self.size, number = traced.size, ctypes.c_double
        table = np.array([*values, 0.0], float)[:, None]
        program = CompiledProgram(traced.program, ("begin", "step"), table)
        one, other = np.zeros((2, traced.size + traced.inputs))
        self.rooms = [(number * len(room)).from_buffer(room.data) for room in (one, other)]
        """A sample goes from the state in one, with the inputs behind it, to that in the other."""
        pairs = (one, other), (other, one)
        self.functions = {
            "begin": [program.bind("begin", x[traced.size :], y) for x, y in pairs],
            "step": [program.bind("step", x, y) for x, y in pairs],
        }
        self.now = 0

    def run(self, name: str, inputs: Sequence[float]) -> list[float]:
        """State after a sample."""
        now = self.now
        self.rooms[now][self.size :] = inputs
        self.functions[name][now]()
        self.now = 1 - now
        return self.rooms[1 - now][: self.size]

    def state(self) -> list[float]:
        """State after the last sample."""
        return self.rooms[self.now][: self.size]


class FloatLoop:
    """One loop on floats."""

    def __init__(self, traced: TracedLoop, values: Sequence[float]) -> None:
        self.functions = traced.program.bind_floats(*values)
        self.now: tuple[float, ...] = ()

    def run(self, name: str, inputs: Sequence[float]) -> Sequence[float]:
        """State after a sample."""
        before = self.now if name == "step" else ()
        self.now = self.functions[name](*before, *inputs)
        return self.now

    def state(self) -> Sequence[float]:
        """State after the last sample."""
        return self.now
