"""Elements of many cells, each with its own phase state and temperature, under one force.

Cells share the force and the current; heat flows between neighbours. A step sweeps over them:
every cell solves its own coupled step in a bracket (`laws.coupling`), with all others folded
into a straight heat line (`elements.network`) and into the free length and compliance of a
spring, as they answered in the sweep before. That is Newton's method for the others and a
bracket for oneself; the mismatch that is left is the residual of the step.

The flux between two cells is weighted between start and end of the step by
θ = (1 + z/3)/(2 + z/3), z = dt G (1/C_i + 1/C_j): the trapezoid where the exchange is slow, the
implicit rule where it is fast. Second order in the step, and no ringing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from martensite.elements.base import AbstractElement, Condition, Heating, Pull, Spring
from martensite.elements.limits import Limits
from martensite.elements.network import Column, others, solved
from martensite.elements.wire import Wire
from martensite.laws.base import AbstractLaw, Fractions
from martensite.laws.coupling import Report, advance
from martensite.runtimes.bracket import UNROLLED
from martensite.runtimes.dual import value_and_slope
from martensite.runtimes.namespace import Namespace, Scalar
from martensite.runtimes.nested import Shape, flatten, total
from martensite.thermal.base import Environment

SWEEPS, MORE_SWEEPS = 3, 10
"""Sweeps of a step, and of one that they leave unsolved."""


class Cells(NamedTuple):
    """State of an element of many cells."""

    memories: tuple[Any, ...]
    """One memory of the law per cell."""
    force: Scalar
    """[N]"""


class Links(NamedTuple):
    """Conductances [W/K]."""

    between: Column
    """From each cell to the next."""
    outside: Column
    """From each cell to the surroundings, besides its surface."""


class Start(NamedTuple):
    """One column per quantity that a step starts from."""

    temperature: Column
    martensite: Column
    oriented: Column
    capacity: Column
    """[J/K]"""
    diagonal: Column
    """Heat capacity and half the loss of the step [J/K]."""
    right: Column
    """Diagonal · T less the heat lost [J]."""
    latent: Column
    """[J]"""
    free: Column
    """[m]"""
    compliance: Column
    """[m/N]"""


class Guess(NamedTuple):
    """One column per quantity that a sweep leaves to the next."""

    martensite: Column
    oriented: Column
    warms: Column
    """Latent heat that a kelvin sets free [J/K]."""
    released: Column
    """Latent heat, as if linear in temperature [J]."""
    free: Column
    """[m]"""
    compliance: Column
    """With what the force transforms [m/N]."""
    crossing: Column


class Lines(NamedTuple):
    """The linear part of the heat balance of a step."""

    diagonal: Column
    right: Column
    """With the heat of the current."""
    links: Column
    current: Scalar
    """[A]"""


class AbstractCells(AbstractElement):
    """Cells of one wire; a subclass cuts it and links the pieces."""

    wire: Wire

    @property
    def law(self) -> AbstractLaw:  # pyright: ignore[reportIncompatibleVariableOverride]
        """The law of the wire."""
        return self.wire.law

    @property
    def limits(self) -> Limits:  # pyright: ignore[reportIncompatibleVariableOverride]
        """The limits of the wire."""
        return self.wire.limits

    def copies(self) -> Scalar:
        """How many equal rows of cells the element has, end to end."""
        return 1.0

    def lengths(self, xp: Namespace) -> Column:
        """Lengths of the cells of one row [m]."""
        raise NotImplementedError

    def links(self, xp: Namespace, fractions: Column) -> Links:
        """What conducts heat at given martensite fractions."""
        raise NotImplementedError

    def cell(self, length: Scalar) -> Wire:
        """A piece of the wire."""
        return self.wire.rebuilt({"length": length})

    def init(self, xp: Namespace, force: Scalar, temperature: Scalar) -> Cells:
        """The state at the start, under `force` [N] and at `temperature` [K]."""
        memory = self.wire.init(xp, force, temperature).memory
        return Cells((memory,) * len(self.lengths(xp)), force)

    def force(self, state: Cells) -> Scalar:
        """Force at the end of the last step [N]."""
        return state.force

    def tangent(self, xp: Namespace, state: Cells, force: Scalar) -> Spring:
        """All cells as one spring."""
        fractions = [self.law.fractions(memory) for memory in state.memories]
        temperatures = [memory.temperature for memory in state.memories]
        return self.together(xp, fractions, temperatures)

    def together(
        self, xp: Namespace, fractions: Sequence[Fractions], temperatures: Column
    ) -> Spring:
        """All cells as one spring at frozen fractions and temperatures [K]."""

        def one(length: Scalar, m: Scalar, o: Scalar, temperature: Scalar) -> tuple[Scalar, Scalar]:
            return self.cell(length).spring(xp, Fractions(m, o), temperature, 0.0)

        m, o = [f.martensite for f in fractions], [f.oriented for f in fractions]
        free, compliance = xp.each(one, self.lengths(xp), m, o, temperatures)
        return Spring(self.copies() * total(free), self.copies() * total(compliance))

    def advance(
        self, xp: Namespace, state: Cells, heating: Heating, pull: Pull, dt: Scalar,
        iterations: int,
    ) -> tuple[Cells, Report]:  # fmt: skip
        """The state after a step of dt [s], and how well the step was solved."""
        step = Step(self, state, heating, pull, dt)
        start = step.start(xp)
        guess = step.unmoved(start)
        for _ in range(SWEEPS if iterations <= UNROLLED else MORE_SWEEPS):
            guess = step.sweep(xp, start, guess, min(iterations, UNROLLED))
        return step.end(xp, start, guess)

    def condition(
        self, xp: Namespace, state: Cells, force: Scalar, environment: Environment
    ) -> Condition:
        """Everything that can be measured on the element under a force [N]."""
        law, lengths = self.law, self.lengths(xp)
        stress = self.wire.stress(xp, force)
        temperatures = [memory.temperature for memory in state.memories]
        fractions = [law.fractions(memory) for memory in state.memories]
        m, o = [f.martensite for f in fractions], [f.oriented for f in fractions]

        def one(length: Scalar, temperature: Scalar, m: Scalar, o: Scalar) -> tuple[Scalar, ...]:
            cell, strain = self.cell(length), law.strain(xp, Fractions(m, o), stress, temperature)
            loss = cell.heat_loss(xp, temperature, environment)
            return loss, cell.ohms(xp, m, strain, temperature)

        losses, ohms = xp.each(one, lengths, temperatures, m, o)
        outside = self.links(xp, m).outside
        ambient = environment.temperature
        drained = [g * (t - ambient) for g, t in zip(outside, temperatures, strict=True)]
        whole = 1.0 / total(lengths)

        def mean(column: Column) -> Scalar:
            return whole * total([w * v for w, v in zip(lengths, column, strict=True)])

        return Condition(
            temperature=mean(temperatures),
            hottest=largest(xp, temperatures),
            martensite_fraction=mean(m),
            oriented_fraction=mean(o),
            stress=stress,
            strain=self.elongation(xp, state, force) / self.wire.length,
            resistance=self.copies() * total(ohms),
            heat_loss=self.copies() * (total(losses) + total(drained)),
        )

    def heat_capacity_total(self) -> Scalar:
        """Heat capacity without transformation [J/K]."""
        return self.wire.heat_capacity_total()

    def heat_loss(self, xp: Namespace, temperature: Scalar, environment: Environment) -> Scalar:
        """Heat flow through the surface [W] if all cells are equally hot."""
        return self.wire.heat_loss(xp, temperature, environment)


@dataclass(frozen=True)
class Step:
    """One step of an element of many cells."""

    element: AbstractCells
    state: Cells
    heating: Heating
    pull: Pull
    dt: Scalar

    @property
    def law(self) -> AbstractLaw:
        """The law of all cells."""
        return self.element.law

    @property
    def memories(self) -> list[Column]:
        """One column per number of the memory."""
        rows = [flatten(memory) for memory in self.state.memories]
        return [list(column) for column in zip(*rows, strict=True)]

    def memory(self, flat: Sequence[Scalar]) -> Any:
        """The memory of one cell."""
        return Shape(self.state.memories[0]).rebuild(flat)

    def start(self, xp: Namespace) -> Start:
        """Where all cells stand."""
        law, force = self.law, self.state.force

        def one(length: Scalar, *flat: Scalar) -> tuple[Scalar, ...]:
            cell, memory = self.element.cell(length), self.memory(flat)
            fractions, temperature = law.fractions(memory), memory.temperature

            def loss(xp: Namespace, temperature: Scalar) -> Scalar:
                return cell.heat_loss(xp, temperature, self.heating.environment)

            lost, slope = value_and_slope(xp, loss, temperature)
            capacity = cell.heat_capacity_total()
            diagonal = capacity + 0.5 * self.dt * slope
            right = diagonal * temperature - self.dt * lost
            latent = cell.latent_heat_total(xp, memory.stress, temperature)
            spring = cell.spring(xp, fractions, temperature, force)
            return (temperature, *fractions, capacity, diagonal, right, latent, *spring)

        return Start(*xp.each(one, self.element.lengths(xp), *self.memories))

    def unmoved(self, start: Start) -> Guess:
        """The guess that nothing transforms."""
        none = [0.0 for _ in start.free]
        return Guess(
            start.martensite, start.oriented, none, none, start.free, start.compliance, none
        )

    def lines(self, xp: Namespace, start: Start, guess: Guess) -> Lines:
        """Heat balance with what is conducted and what the current brings."""
        middle = [0.5 * (a + b) for a, b in zip(start.martensite, guess.martensite, strict=True)]
        current, joule = self._joule(xp, middle)
        links, ambient = self.element.links(xp, middle), self.heating.environment.temperature
        diagonal = list(start.diagonal)
        right = [a + b for a, b in zip(start.right, joule, strict=True)]
        t, c, between = start.temperature, start.capacity, list[Scalar]()
        for i, g in enumerate(links.outside):
            now, later = _shares(self.dt * g, 1.0 / c[i])
            diagonal[i] = diagonal[i] + later
            right[i] = right[i] + later * ambient + now * (ambient - t[i])
        for i, g in enumerate(links.between):
            now, later = _shares(self.dt * g, 1.0 / c[i] + 1.0 / c[i + 1])
            flow = now * (t[i + 1] - t[i])
            right[i], right[i + 1] = right[i] + flow, right[i + 1] - flow
            between.append(later)
        return Lines(diagonal, right, between, current)

    def _joule(self, xp: Namespace, middle: Column) -> tuple[Scalar, list[Scalar]]:
        """Current [A], and the heat it brings to every cell [J]."""

        def one(length: Scalar, x: Scalar, *flat: Scalar) -> tuple[Scalar]:
            memory = self.memory(flat)
            return (self._ohms(xp, self.element.cell(length), memory, x),)

        (ohms,) = xp.each(one, self.element.lengths(xp), middle, *self.memories)
        current = self.heating.current(xp, self.element.copies() * total(ohms))
        return current, [self.dt * current * current * r for r in ohms]

    def _ohms(self, xp: Namespace, cell: Wire, memory: Any, x: Scalar) -> Scalar:
        """Resistance of a cell at a fraction, else as at the start of the step."""
        law = self.law
        strain = law.strain(xp, law.fractions(memory), memory.stress, memory.temperature)
        return cell.ohms(xp, x, strain, memory.temperature)

    def sweep(self, xp: Namespace, start: Start, guess: Guess, iterations: int) -> Guess:
        """Every cell for itself, with the others as they answered before."""
        lines = self.lines(xp, start, guess)
        seen = others(
            [d + w for d, w in zip(lines.diagonal, guess.warms, strict=True)],
            [r + q for r, q in zip(lines.right, guess.released, strict=True)],
            lines.links,
        )
        free, compliance = total(guess.free), total(guess.compliance)

        def one(*row: Scalar) -> tuple[Scalar, ...]:
            return self._alone(xp, iterations, row)

        found = xp.each(
            one,
            self.element.lengths(xp), start.martensite, start.latent,
            [d + b for d, b in zip(lines.diagonal, seen.slope, strict=True)],
            [r + s for r, s in zip(lines.right, seen.source, strict=True)],
            [free - f for f in guess.free],
            [compliance - c for c in guess.compliance],
            *self.memories,
        )  # fmt: skip
        return Guess(*found)

    def _alone(self, xp: Namespace, iterations: int, row: Sequence[Scalar]) -> tuple[Scalar, ...]:
        """One cell's own step, and how it answers to a little more heat or force."""
        length, x0, latent, diagonal, right, free, compliance = row[:7]
        cell, law, memory = self.element.cell(length), self.law, self.memory(row[7:])
        imposed, copies = self.heating.temperature, self.element.copies()

        def settle(xp: Namespace, fractions: Fractions) -> tuple[Scalar, Scalar]:
            at = (right + latent * (fractions.martensite - x0)) / diagonal
            at = at if imposed is None else imposed
            own = cell.spring(xp, fractions, at, 0.0)
            whole = Spring(copies * (free + own.free), copies * (compliance + own.compliance))
            return cell.stress(xp, self.pull(xp, whole)), at

        after, report = advance(xp, law, memory, settle, self.dt, iterations)
        end, stress, at = law.fractions(after), after.stress, after.temperature

        def fraction(xp: Namespace, temperature: Scalar) -> Scalar:
            return law.kinetics(xp, memory, stress, temperature, self.dt)[1].martensite

        def stretched(xp: Namespace, stress: Scalar) -> Scalar:
            found = law.kinetics(xp, memory, stress, at, self.dt)[1]
            return law.strain(xp, found, stress, at)

        warms = latent * xp.maximum(-value_and_slope(xp, fraction, at)[1], 0.0)
        elastic, yields = law.compliance(xp, end), value_and_slope(xp, stretched, stress)[1]
        restrained = xp.maximum(yields - elastic, 0.0) / (1.0 + warms / diagonal)
        soft = length * (elastic + restrained)
        return (
            *end, warms, latent * (end.martensite - x0) + warms * at,
            length * law.strain(xp, end, stress, at) - soft * stress,
            soft * cell.stress(xp, 1.0), report.crossing,
        )  # fmt: skip

    def end(self, xp: Namespace, start: Start, guess: Guess) -> tuple[Cells, Report]:
        """All cells together, at the fractions found."""
        law, element = self.law, self.element
        temperatures = self._settled(xp, start, guess)
        fractions = [Fractions(*pair) for pair in zip(*guess[:2], strict=True)]
        force = self.pull(xp, element.together(xp, fractions, temperatures))
        stress = element.wire.stress(xp, force)

        def one(m: Scalar, o: Scalar, temperature: Scalar, *flat: Scalar) -> list[Scalar]:
            memory, at = self.memory(flat), Fractions(m, o)
            move = law.select(xp, memory, stress, temperature)
            found = law.follow(xp, move, stress, temperature, self.dt)
            after = law.commit(xp, memory, move, at, stress, temperature, self.dt)
            off = xp.maximum(xp.abs(found.martensite - m), xp.abs(found.oriented - o))
            return [off, *flatten(after)]

        residuals, *columns = xp.each(one, *guess[:2], temperatures, *self.memories)
        shape = Shape(self.state.memories[0])
        memories = tuple(shape.rebuild(flat) for flat in zip(*columns, strict=True))
        report = Report(largest(xp, residuals), largest(xp, guess.crossing))
        return Cells(memories, force), report

    def _settled(self, xp: Namespace, start: Start, guess: Guess) -> Column:
        """Temperatures at the end of the step, at the fractions found; no heat is lost."""
        imposed = self.heating.temperature
        if imposed is not None:
            return [imposed for _ in start.temperature]
        lines = self.lines(xp, start, guess)
        rows = zip(lines.right, start.latent, guess.martensite, start.martensite, strict=True)
        right = [r + latent * (x - x0) for r, latent, x, x0 in rows]
        return solved(lines.diagonal, right, lines.links)


def _shares(amount: Scalar, rate: Scalar) -> tuple[Scalar, Scalar]:
    """Parts of an exchange that go by the temperatures at the start and at the end."""
    third = amount * rate * (1.0 / 3.0)
    later = amount * ((1.0 + third) / (2.0 + third))
    return amount - later, later


def largest(xp: Namespace, column: Column) -> Scalar:
    """The largest number of a column."""
    result = column[0]
    for number in column[1:]:
        result = xp.maximum(result, number)
    return result
