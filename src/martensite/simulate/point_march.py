"""Simulation of a material point along its legs, on plain floats or in C.

Unsolved steps are repeated in halves, on floats.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, cast

from martensite.base.status import Status
from martensite.kernels.compiler import call_compiled, read_source
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.simulate.compiled_law import ROW, CompiledLaw, compile_law
from martensite.simulate.march import SOLVED, classify_step
from martensite.simulate.marching import Row

if TYPE_CHECKING:
    from martensite.kernels.compiled_program import CompiledProgram

SPLITS = 4
"""Maximum halvings of an unsolved step, on floats."""
STRAIN, STRESS = ROW.index("strain"), ROW.index("stress")


class PathSection(NamedTuple):
    """Leg with all values that are known before the simulation."""

    control: str
    """`stress` or `strain`."""
    end: float | None
    """Stress [Pa] or strain [-] at the end; None for the present value."""
    first: float
    last: float
    """Temperatures at both ends [K]."""
    duration: float
    samples: int
    begin: float = math.nan
    """Stress [Pa] or strain [-] at the start, from the simulation."""

    def start(self, row: Row, imposed: float | None) -> PathSection:
        """Return the section with both ends known; a slack point is longer than the prescribed strain."""
        begin = row[STRESS]
        if self.control == "strain":
            begin = row[STRAIN] if imposed is None else imposed
        return self._replace(begin=begin, end=begin if self.end is None else self.end)

    def at(self, share: float) -> tuple[float, float]:
        """Return the prescribed quantity and temperature at a fraction of the section; exact at its end."""
        end = self.begin if self.end is None else self.end
        if share == 1.0:
            return end, self.last
        return self.begin + share * (end - self.begin), self.first + share * (self.last - self.first)


class PathSectionResult(NamedTuple):
    """Result of one section."""

    memory: Row
    """Memory and its row."""
    rows: list[Row]
    residual: float
    step: int
    """First step with this residual."""


@dataclass(frozen=True)
class PointTrack:
    """Rows at the samples, and the status of the steps."""

    rows: list[Row]
    """Rows in the layout of `compiled_law.ROW`."""
    status: Status
    residual: float
    leg: int
    time: float
    """Leg and time [s] of the worst step."""
    steps: int


@dataclass(frozen=True)
class PathDriver:
    """Law and path with all settings except the steps."""

    law: AbstractLaw
    fractions: Fractions
    stress: float
    temperature: float
    sections: Sequence[PathSection]
    tension_only: bool
    runtime: str

    @property
    def samples(self) -> int:
        """Return the samples after the first one."""
        return sum(section.samples for section in self.sections)

    @cached_property
    def rider(self) -> FloatRider | NativeRider:
        """Return the runtime with bound parameters."""
        if self.runtime == "c":
            return NativeRider(self.compiled, self.law)
        return FloatRider(self)

    @cached_property
    def compiled(self) -> CompiledLaw:
        """Return the traced law."""
        return compile_law(self.law, tension_only=self.tension_only)


def march_point(drive: PathDriver, finer: int) -> PointTrack:
    """Simulate with `finer` steps between samples; failures set the status."""
    rider = drive.rider
    size = drive.compiled.size
    state = rider.start(*drive.fractions, drive.stress, drive.temperature)
    rows = [state[size:]]
    worst, leg, when = 0.0, 0, 0.0
    clock, imposed = 0.0, cast("float | None", None)
    for number, leg_section in enumerate(drive.sections):
        section = leg_section.start(rows[-1], imposed)
        imposed = section.end if section.control == "strain" else None
        try:
            ridden = rider.ride(state[:size], section, finer)
        except ArithmeticError:  # division by zero or overflow
            return PointTrack(rows, Status.NOT_FINITE, math.inf, number, clock, 0)
        if not ridden.residual <= worst:
            dt = section.duration / (section.samples * finer)
            worst, leg, when = ridden.residual, number, clock + dt * ridden.step
        rows += ridden.rows
        state = ridden.memory
        clock += section.duration
    finite = all(math.isfinite(value) for row in rows for value in row)
    status = classify_step(worst, 0.0) if finite else Status.NOT_FINITE
    return PointTrack(rows, status, worst, leg, when, finer * drive.samples)


class FloatRider:
    """Traced functions as plain Python."""

    def __init__(self, drive: PathDriver) -> None:
        compiled = drive.compiled
        self._size = compiled.size
        self._functions = compiled.program.bind_floats(*compiled.values(drive.law))

    def start(self, *numbers: float) -> Row:
        """Return the memory and row at ξ [-], ξ_S [-], stress [Pa], temperature [K]."""
        return self._functions["init"](*numbers)

    def _carefully(
        self, state: Row, begin: tuple[float, float], end: tuple[float, float], dt: float, splits: int
    ) -> Row:
        """Return a strain-driven step, in halves if it is unsolved."""
        after = self._functions["strain_step"](*state, *end, dt)
        if after[-1] <= SOLVED or splits == 0:
            return after
        middle = 0.5 * (begin[0] + end[0]), 0.5 * (begin[1] + end[1])
        first = self._carefully(state, begin, middle, 0.5 * dt, splits - 1)
        last = self._carefully(first[: self._size], middle, end, 0.5 * dt, splits - 1)
        return (*last[:-1], max(first[-1], last[-1]))

    def ride(self, memory: Row, section: PathSection, finer: int) -> PathSectionResult:
        """Run a section with the given number of steps between samples."""
        step, size, count = self._functions[f"{section.control}_step"], self._size, section.samples * finer
        dt = section.duration / count
        rows: list[Row] = []
        worst, where = 0.0, 0
        state = memory
        for k in range(1, count + 1):
            given = section.at(k / count)
            after = step(*state, *given, dt)
            if not after[-1] <= SOLVED:
                after = self._carefully(state, section.at((k - 1) / count), given, dt, SPLITS)
            if not after[-1] <= worst:
                worst, where = after[-1], k - 1
            state = after[:size]
            if k % finer == 0:
                rows.append(after[size:])
        return PathSectionResult((*state, *rows[-1]), rows, worst, where)


class NativeRider:
    """Traced functions in C."""

    def __init__(self, compiled: CompiledLaw, law: AbstractLaw) -> None:
        import numpy as np

        self._compiled = compiled
        self._table = np.array([*compiled.values(law), 0.0], float)[:, None]
        self._programs: dict[str, CompiledProgram] = {}

    def _load(self, step: str) -> CompiledProgram:
        """Load one library per kind of step, since unused functions take seconds to compile."""
        if step in self._programs:
            return self._programs[step]
        from martensite.kernels.compiled_program import CompiledProgram

        size = self._compiled.size
        row, results = len(ROW), size + len(ROW)
        constants = {"INPUTS": max(size + 3, 4), "RESULTS": results, "SIZE": size, "ROW": row, "STEP": f"k_{step}"}
        added = read_source("simulate", "ride.c", constants)
        program = CompiledProgram(self._compiled.program, ("init", step), self._table, added)
        return self._programs.setdefault(step, program)

    def start(self, *numbers: float) -> tuple[float, ...]:
        """Return the memory and row at ξ [-], ξ_S [-], stress [Pa], temperature [K]."""
        import numpy as np

        memory_row, given = np.empty(self._compiled.size + len(ROW)), np.array(numbers, float)
        self._load("stress_step").bind("init", given, memory_row)()
        return tuple(memory_row.tolist())

    def ride(self, memory: Row, section: PathSection, finer: int) -> PathSectionResult:
        """Run a section with the given number of steps between samples."""
        import numpy as np

        state, worst = np.array(memory, float), np.empty(1)
        rows, where = np.empty((section.samples, len(ROW))), np.empty(1, np.int_)
        dt = section.duration / (section.samples * finer)
        line = np.array([section.begin, section.end, section.first, section.last, dt], float)
        program = self._load(f"{section.control}_step")
        arrays = (program.constants, line, state, rows, worst, where)
        call_compiled(program.library.ride, section.samples, finer, *arrays)
        samples = [tuple(row) for row in rows.tolist()]
        return PathSectionResult((*state.tolist(), *samples[-1]), samples, float(worst[0]), int(where[0]))
