"""Tracing a system: its kernels as a program over flat states, cached by structure.

Numbers never enter the trace: a changed value reuses the program, a changed law, option or
mechanism makes a new one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from martensite.laws.coupling import Report
from martensite.parameters import Keyed, values_at
from martensite.runtimes.nested import Shape, flatten
from martensite.runtimes.once import once
from martensite.runtimes.program import Program
from martensite.system import PROFILES, AbstractSystem

Functions = Mapping[str, Callable[..., tuple[float, ...]]]


@dataclass(frozen=True, eq=False)
class Compiled:
    """A traced system; functions `init`, `step` and `observe` over flat states."""

    program: Program
    paths: tuple[str, ...]
    """Parameter paths in the order in which the program takes them."""
    size: int
    """Number of state variables."""
    drives: int
    """Number of drive signals."""
    outputs: tuple[str, ...]
    """Those of the system, then the profile of its element: `cell_temperature[0]`, …"""
    report: tuple[str, ...] = Report._fields

    def values(self, system: AbstractSystem) -> list[float]:
        """Parameter values of a system of this structure, in order."""
        return values_at(system, self.paths)


def compile_system(system: AbstractSystem) -> Compiled:
    """Trace a system, or return the program of an earlier one of the same structure."""
    return _compile(Keyed(system))


def bind_system(system: AbstractSystem) -> tuple[Functions, int]:
    """The functions of a system on floats, with its numbers, and how many states it has."""
    compiled = compile_system(system)
    return compiled.program.bind_floats(*compiled.values(system)), compiled.size


@once(64)
def _compile(keyed: Keyed[AbstractSystem]) -> Compiled:
    program = Program()
    paths = tuple(leaf.path for leaf in keyed.part.leaves())
    system = keyed.part.rebuilt({path: program.parameter(path) for path in paths})
    found: list[Shape] = []

    def init(xp: Any, *drives: Any) -> list[Any]:
        state = system.init(xp, *drives)
        found.append(Shape(state))
        return flatten(state)

    signals = [f"u{i}" for i in range(len(system.drives()))]
    program.add("init", signals, init)
    shape, size = found[0], len(flatten(found[0].example))
    names = [f"s{i}" for i in range(size)]
    program.add("step", [*names, *signals, "dt"], _step_kernel(system, shape, size))
    program.add("observe", [*names, *signals], _observe_kernel(system, shape, size))
    profile = system.profile(shape.example)
    along = (f"{n}[{i}]" for n, c in zip(PROFILES, profile, strict=False) for i in range(len(c)))
    outputs = (*keyed.part.outputs(), *along)
    return Compiled(program, paths, size, len(signals), outputs)


def _step_kernel(system: AbstractSystem, shape: Shape, size: int) -> Callable[..., list[Any]]:
    def step(xp: Any, *arguments: Any) -> list[Any]:
        *numbers, dt = arguments
        state, drives = shape.rebuild(numbers[:size]), numbers[size:]
        after, report = system.step(xp, state, *drives, dt=dt)
        return flatten(after) + flatten(report)

    return step


def _observe_kernel(system: AbstractSystem, shape: Shape, size: int) -> Callable[..., list[Any]]:
    def observe(xp: Any, *arguments: Any) -> list[Any]:
        state, drives = shape.rebuild(arguments[:size]), arguments[size:]
        along = [number for column in system.profile(state) for number in column]
        return [*system.observe(xp, state, *drives), *along]

    return observe
