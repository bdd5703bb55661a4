"""Tracing a system: its kernels as a program over flat states, cached by structure.

Numbers never enter the trace: a changed value reuses the program, a changed law, option or
mechanism makes a new one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from martensite.laws.coupling import Report
from martensite.parameters import Parametrised
from martensite.runtimes.bracket import ITERATIONS
from martensite.runtimes.nested import Shape, flatten
from martensite.runtimes.program import Program
from martensite.system import OUTPUTS, PROFILES, System


@dataclass(frozen=True, eq=False)
class Compiled:
    """A traced system; functions `init`, `step` and `observe` over flat states."""

    program: Program
    paths: tuple[str, ...]
    """Parameter paths in the order in which the program takes them."""
    size: int
    """Number of state variables."""
    report: tuple[str, ...] = Report._fields
    outputs: tuple[str, ...] = tuple(OUTPUTS)
    """Those of every system, then the profile of its element: `cell_temperature[0]`, …"""

    def values(self, system: System) -> list[float]:
        """Parameter values of a system of this structure, in order."""
        known = {leaf.path: leaf.value for leaf in system.leaves()}
        return [known[path] for path in self.paths]


def structure(part: Parametrised) -> tuple[Any, ...]:
    """A hashable description of everything but the numbers."""
    options = tuple(
        (name, getattr(part, name))
        for name, declared in part.declarations.items()
        if declared.kind == "option"
    )
    return type(part), options, tuple((name, structure(child)) for name, child in part.children())


def compile_system(system: System, iterations: int = ITERATIONS) -> Compiled:
    """Trace a system, or return the program of an earlier one of the same structure.

    `iterations` is the fixed count of the bracketed solve of every step.
    """
    return _compile(_Keyed(structure(system), system), iterations)


@dataclass(frozen=True)
class _Keyed:
    key: tuple[Any, ...]
    system: System

    def __hash__(self) -> int:
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Keyed) and self.key == other.key


@lru_cache(maxsize=64)
def _compile(keyed: _Keyed, iterations: int) -> Compiled:
    program = Program()
    paths = tuple(leaf.path for leaf in keyed.system.leaves())
    system = keyed.system.rebuilt({path: program.parameter(path) for path in paths})
    found: list[Shape] = []

    def init(xp: Any, drive: Any) -> list[Any]:
        state = system.init(xp, drive)
        found.append(Shape(state))
        return flatten(state)

    program.add("init", ["u"], init)
    shape, size = found[0], len(flatten(found[0].example))
    names = [f"s{i}" for i in range(size)]
    program.add("step", [*names, "u", "dt"], _step_kernel(system, shape, iterations))
    program.add("observe", [*names, "u"], _observe_kernel(system, shape))
    cells = len(system.profile(shape.example).cell_temperature)
    along = (f"{name}[{i}]" for name in PROFILES for i in range(cells))
    return Compiled(program, paths, size, outputs=(*OUTPUTS, *along))


def _step_kernel(system: System, shape: Shape, iterations: int) -> Callable[..., list[Any]]:
    def step(xp: Any, *arguments: Any) -> list[Any]:
        *numbers, drive, dt = arguments
        state, report = system.step(xp, shape.rebuild(numbers), drive, dt, iterations)
        return flatten(state) + flatten(report)

    return step


def _observe_kernel(system: System, shape: Shape) -> Callable[..., list[Any]]:
    def observe(xp: Any, *arguments: Any) -> list[Any]:
        *numbers, drive = arguments
        state = shape.rebuild(numbers)
        along = [number for column in system.profile(state) for number in column]
        return [*flatten(system.observe(xp, state, drive)), *along]

    return observe
