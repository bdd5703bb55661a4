"""The march of a material point along its legs, on plain floats or in C.

A step that is left unsolved is taken again in halves, on floats.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from martensite.base.status import Status
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.simulate.compiled_law import ROW, CompiledLaw, compile_law
from martensite.simulate.march import SOLVED, classify_step

if TYPE_CHECKING:
    from martensite.simulate.point_native import NativeRider

SPLITS = 4
"""How often a step that stays unsolved is halved, on floats."""
STRAIN, STRESS = ROW.index("strain"), ROW.index("stress")


class PathSection(NamedTuple):
    """One leg with everything filled in that is known before the march."""

    control: str
    """`stress` or `strain`."""
    target: float | None
    """Stress [Pa] or strain [-] at the end; None holds what is there."""
    first: float
    last: float
    """Temperatures at its two ends [K]."""
    duration: float
    samples: int


class RampSection(NamedTuple):
    """A section whose prescribed quantity is known at both ends, in equal steps."""

    control: str
    begin: float
    end: float
    first: float
    last: float
    dt: float
    samples: int
    finer: int
    """Steps between samples."""

    def at(self, k: int) -> tuple[float, float]:
        """Prescribed quantity and temperature after k steps; exact at the end."""
        n = self.samples * self.finer
        if k == n:
            return self.end, self.last
        share = k / n
        return (self.begin + share * (self.end - self.begin), self.first + share * (self.last - self.first))


class Ridden(NamedTuple):
    """What a march along one section returns."""

    memory: tuple[float, ...]
    """With the row that follows it."""
    rows: list[tuple[float, ...]]
    residual: float
    step: int
    """The first step with this residual."""


@dataclass(frozen=True)
class PointTrack:
    """Rows at the samples, and how the steps ended."""

    rows: list[tuple[float, ...]]
    """As `compiled_law.ROW`."""
    status: Status
    residual: float
    leg: int
    time: float
    """Leg and time [s] of the worst step."""
    steps: int


@dataclass(frozen=True)
class PathDriver:
    """A law and its path; everything about a march but its steps."""

    law: AbstractLaw
    fractions: Fractions
    stress: float
    temperature: float
    sections: Sequence[PathSection]
    tension_only: bool
    runtime: str

    @property
    def samples(self) -> int:
        """Samples after the first one."""
        return sum(section.samples for section in self.sections)

    @cached_property
    def rider(self) -> FloatRider | NativeRider:
        """The runtime, with the parameters bound."""
        if self.runtime == "c":
            from martensite.simulate.point_native import NativeRider

            return NativeRider(self.compiled, self.law)
        return FloatRider(self)

    @cached_property
    def compiled(self) -> CompiledLaw:
        """The traced law."""
        return compile_law(self.law, tension_only=self.tension_only)


def march_point(drive: PathDriver, finer: int) -> PointTrack:
    """March with `finer` steps between samples; failures are a status."""
    rider = drive.rider
    size = drive.compiled.size
    state = rider.start(*drive.fractions, drive.stress, drive.temperature)
    rows = [state[size:]]
    worst, leg, when = 0.0, 0, 0.0
    clock, imposed = 0.0, None
    for number, section in enumerate(drive.sections):
        ramp = _start_section(section, finer, rows[-1], imposed)
        imposed = ramp.end if section.control == "strain" else None
        try:
            ridden = rider.ride(state[:size], ramp)
        except ArithmeticError:  # a division by zero or an overflow
            return PointTrack(rows, Status.NOT_FINITE, math.inf, number, clock, 0)
        if not ridden.residual <= worst:
            worst, leg, when = ridden.residual, number, clock + ramp.dt * ridden.step
        rows += ridden.rows
        state = ridden.memory
        clock += section.duration
    finite = all(math.isfinite(value) for row in rows for value in row)
    status = classify_step(worst, 0.0) if finite else Status.NOT_FINITE
    return PointTrack(rows, status, worst, leg, when, finer * drive.samples)


def _start_section(section: PathSection, finer: int, row: tuple[float, ...], imposed: float | None) -> RampSection:
    """Where a section begins: a slack point is longer than the strain imposed on it."""
    begin = row[STRESS]
    if section.control == "strain":
        begin = row[STRAIN] if imposed is None else imposed
    end = begin if section.target is None else section.target
    dt = section.duration / (section.samples * finer)
    return RampSection(section.control, begin, end, section.first, section.last, dt, section.samples, finer)


class FloatRider:
    """Traced functions as plain Python."""

    def __init__(self, drive: PathDriver) -> None:
        compiled = drive.compiled
        self._size = compiled.size
        self._functions = compiled.program.bind_floats(*compiled.values(drive.law))

    def start(self, *numbers: float) -> tuple[float, ...]:
        """Memory and row at ξ [-], ξ_S [-], stress [Pa], temperature [K]."""
        return self._functions["init"](*numbers)

    def _carefully(
        self, state: tuple[float, ...], begin: tuple[float, float], end: tuple[float, float], dt: float, splits: int
    ) -> tuple[float, ...]:
        """A strain-driven step; in two halves where it stays unsolved."""
        after = self._functions["strain_step"](*state, *end, dt)
        if after[-1] <= SOLVED or splits == 0:
            return after
        middle = 0.5 * (begin[0] + end[0]), 0.5 * (begin[1] + end[1])
        first = self._carefully(state, begin, middle, 0.5 * dt, splits - 1)
        last = self._carefully(first[: self._size], middle, end, 0.5 * dt, splits - 1)
        return (*last[:-1], max(first[-1], last[-1]))

    def ride(self, memory: tuple[float, ...], ramp: RampSection) -> Ridden:
        """Along one section."""
        step, size, dt = self._functions[f"{ramp.control}_step"], self._size, ramp.dt
        rows: list[tuple[float, ...]] = []
        worst, where = 0.0, 0
        state = memory
        for k in range(1, ramp.samples * ramp.finer + 1):
            given = ramp.at(k)
            after = step(*state, *given, dt)
            if not after[-1] <= SOLVED:
                after = self._carefully(state, ramp.at(k - 1), given, dt, SPLITS)
            if not after[-1] <= worst:
                worst, where = after[-1], k - 1
            state = after[:size]
            if k % ramp.finer == 0:
                rows.append(after[size:])
        return Ridden((*state, *rows[-1]), rows, worst, where)
