"""One step of an element of many cells.

Cells share force and current; heat flows between neighbours. A step sweeps over them: each cell solves its own coupled
step in a bracket (`laws.coupling`), with all others as a linear heat balance and a spring (`elements.network`) from the
previous sweep. This is Newton's method for the others and a bracket for the cell itself; the remaining mismatch is the
residual of the step.

The flux between two cells is weighted between start and end of the step by θ = (1 + z/3)/(2 + z/3), z = dt G (1/C_i +
1/C_j): trapezoidal for slow exchange, implicit for fast exchange. Second order, without ringing.
"""

from __future__ import annotations

import operator
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from martensite.actuators.elements.base import Heating, Pull
from martensite.actuators.elements.columns import Cells, HeatBalanceColumns, StepStart, SweepGuess
from martensite.actuators.elements.heat_steps import compute_relaxation
from martensite.actuators.elements.network import Column, Rest, fold_others, solve_cells, solve_tridiagonal
from martensite.kernels.dual import value_and_slope, values_and_slopes
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, find_largest, flatten_numbers, map_rows, sum_columns
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.physics.laws.coupling import StepReport, advance_memory

if TYPE_CHECKING:
    from martensite.actuators.elements.cells import AbstractCut


@dataclass(frozen=True)
class SweepStep:
    """One step of an element of many cells."""

    element: AbstractCut
    state: Cells
    heating: Heating
    pull: Pull
    dt: Scalar

    @property
    def law(self) -> AbstractLaw:
        """Return the law of all cells."""
        return self.element.law

    @property
    def memories(self) -> list[Column]:
        """Return one column per value of the memory."""
        rows = [flatten_numbers(memory) for memory in self.state.memories]
        return [list(column) for column in zip(*rows, strict=True)]

    def memory(self, flat: Sequence[Scalar]) -> Any:
        """Return the memory of one cell."""
        return NestedShape(self.state.memories[0]).rebuild(flat)

    def start(self, xp: Namespace) -> StepStart:
        """Return the initial state of all cells."""
        law = self.law

        def one(length: Scalar, *flat: Scalar) -> tuple[Scalar, ...]:
            cell, memory = self.element.cell(length), self.memory(flat)
            fractions, temperature = law.fractions(memory), memory.temperature

            def loss(xp: Namespace, temperature: Scalar) -> Scalar:
                return cell.heat_loss(xp, temperature, self.heating.environment)

            lost, slope = value_and_slope(xp, loss, temperature)
            capacity = cell.heat_capacity_total()
            diagonal = capacity * compute_relaxation(xp, self.dt * slope / capacity)
            right = diagonal * temperature - self.dt * lost
            latent = cell.latent_heat_total(xp, memory.stress, temperature)
            long = length * law.strain(xp, fractions, memory.stress, temperature)
            elastic = length * cell.stress(xp, 1.0) * law.compliance(xp, fractions)
            return temperature, *fractions, capacity, diagonal, right, latent, long, elastic

        return StepStart(*xp.each(one, self.element.lengths(xp), *self.memories))

    def guess_without_transformation(self, xp: Namespace, start: StepStart) -> SweepGuess:
        """Return the guess without transformation."""
        none = [0.0 for _ in start.long]
        columns = (
            start.martensite,
            start.oriented,
            start.temperature,
            self.element.force_on_cells(xp, self.state),
            start.long,
            start.elastic,
            start.elastic,
            none,
            none,
            none,
            none,
        )
        return SweepGuess(*(tuple(column) for column in columns))

    def lines(self, xp: Namespace, start: StepStart, guess: SweepGuess) -> HeatBalanceColumns:
        """Return the heat balance with conduction and Joule heat."""
        middle = _average_ends(xp, start.martensite, guess.martensite)
        joule = self._joule(xp, start, guess)
        links, ambient = self.element.links(xp, middle), self.heating.environment.temperature
        t, c = start.temperature, start.capacity

        def flow(g: Scalar, t: Scalar, beyond: Scalar, c: Scalar, other: Scalar) -> tuple[Scalar, Scalar]:
            now, later = _split_exchange(self.dt * g, 1.0 / c + 1.0 / other)
            return now * (beyond - t), later

        flows, between = xp.each(flow, links.between, t[:-1], t[1:], c[:-1], c[1:])
        outside = [_split_exchange(self.dt * g, 1.0 / one) for g, one in zip(links.outside, c, strict=True)]

        def balance(
            before: Scalar,
            after: Scalar,
            d: Scalar,
            right: Scalar,
            joule: Scalar,
            t: Scalar,
            now: Scalar,
            later: Scalar,
        ) -> tuple[Scalar, ...]:
            return after, d + later, right + joule + later * ambient + now * (ambient - t) - before + after

        columns = [*flows, 0.0], start.diagonal, start.right, joule, t, *zip(*outside, strict=True)
        _, diagonal, right = xp.scan(balance, (0.0,), *columns)
        return HeatBalanceColumns(diagonal, right, between)

    def _joule(self, xp: Namespace, start: StepStart, guess: SweepGuess) -> list[Scalar]:
        """Return the Joule heat of each cell [J], from mid-step states."""
        ohms, heated = self._ohms(xp, start, guess)
        per_ohm = self.dt * self.heating.heat(xp, ohms).mean / ohms
        return [per_ohm * r for r in heated]

    def _ohms(self, xp: Namespace, start: StepStart, guess: SweepGuess) -> tuple[Scalar, Column]:
        """Return the resistance of the element, and of each cell to the current in it [ohm]."""
        element = self.element

        def one(
            length: Scalar, x: Scalar, share: Scalar, first: Scalar, last: Scalar, long: Scalar, longer: Scalar
        ) -> tuple[Scalar, ...]:
            strain = 0.5 * (long + longer) / length
            ohms = element.cell(length).ohms(xp, x, strain, 0.5 * (first + last))
            return share * ohms, share * share * ohms

        columns = (
            element.lengths(xp),
            _average_ends(xp, start.martensite, guess.martensite),
            element.shares(xp),
            start.temperature,
            guess.temperature,
            start.long,
            guess.long,
        )
        resistances, heated = xp.each(one, *columns)
        return element.copies() * sum_columns(xp, resistances)[0], heated

    def sweep(self, xp: Namespace, start: StepStart, guess: SweepGuess) -> SweepGuess:
        """Return each cell solved alone, with the others from the previous sweep."""
        lines = self.lines(xp, start, guess)
        diagonal = map_rows(xp, operator.add, lines.diagonal, guess.warms)
        expected = self._expect_latent_heat(xp, start, guess, lines)
        slope, source, felt = fold_others(xp, diagonal, lines.links, expected, guess.gives)
        rests = self._rests(xp, guess, solve_cells(xp, diagonal, guess.gives, slope, felt))

        def one(*row: Scalar) -> tuple[Scalar, ...]:
            return self._solve_cell(xp, row)

        rows = xp.each(
            one,
            self.element.lengths(xp),
            start.martensite,
            start.latent,
            [d + b for d, b in zip(lines.diagonal, slope, strict=True)],
            [r + s for r, s in zip(lines.right, source, strict=True)],
            felt,
            guess.force,
            *rests,
            *self.memories,
        )
        return SweepGuess(*(tuple(column) for column in rows))

    def _expect_latent_heat(
        self, xp: Namespace, start: StepStart, guess: SweepGuess, lines: HeatBalanceColumns
    ) -> Column:
        """Return the right-hand side with latent heat linearised in temperature [J]."""

        def expect(r: Scalar, latent: Scalar, x: Scalar, x0: Scalar, warms: Scalar, t: Scalar) -> Scalar:
            return r + latent * (x - x0) + warms * t

        columns = lines.right, start.latent, guess.martensite, start.martensite, guess.warms, guess.temperature
        return map_rows(xp, expect, *columns)

    def _rests(self, xp: Namespace, guess: SweepGuess, heated: Column) -> tuple[Column, Column]:
        """Return the others as springs; more force on all of them also heats them [K/N]."""

        def rest(c: Scalar, s: Scalar, h: Scalar, least: Scalar, long: Scalar, force: Scalar) -> tuple[Scalar, Scalar]:
            soft = xp.maximum(c + s * h, least)
            return long - soft * force, soft

        columns = guess.soft, guess.shrinks, heated, guess.elastic, guess.long, guess.force
        free, soft = xp.each(rest, *columns)
        return self.element.linkage().rests(xp, free, soft, guess.force)

    def _solve_cell(self, xp: Namespace, row: Sequence[Scalar]) -> tuple[Scalar, ...]:
        """Return one cell's step, and its derivatives with respect to heat and force."""
        length, x0, latent, diagonal, right, felt, before, *rest = row[:9]
        cell, law, memory = self.element.cell(length), self.law, self.memory(row[9:])
        imposed, linkage = self.heating.temperature, self.element.linkage()

        def settle(xp: Namespace, fractions: Fractions) -> tuple[Scalar, Scalar]:
            at = (right + latent * (fractions.martensite - x0)) / diagonal
            own = cell.spring(xp, fractions, at if imposed is None else imposed, 0.0)
            whole = linkage.combine_springs(Rest(*rest), own)
            force = linkage.force_share(xp, own, whole, self.pull(xp, whole))
            at = at + felt * (force - before) / diagonal
            return cell.stress(xp, force), at if imposed is None else imposed

        after, report = advance_memory(xp, law, memory, settle, self.dt)
        end, stress, at = law.fractions(after), after.stress, after.temperature

        def moved(xp: Namespace, stress: Scalar, at: Scalar) -> tuple[Scalar, Scalar]:
            fractions = law.kinetics(xp, memory, stress, at, self.dt)[1]
            return fractions.martensite, law.strain(xp, fractions, stress, at)

        _, by_heat = values_and_slopes(xp, lambda xp, at: moved(xp, stress, at), at)
        _, by_stress = values_and_slopes(xp, lambda xp, stress: moved(xp, stress, at), stress)
        per_force, elastic = cell.stress(xp, 1.0), law.compliance(xp, end)
        return (
            *end,
            at,
            stress / per_force,
            length * law.strain(xp, end, stress, at),
            length * per_force * elastic,
            length * per_force * xp.maximum(by_stress[1], elastic),
            length * by_heat[1],
            latent * xp.maximum(-by_heat[0], 0.0),
            latent * per_force * xp.maximum(by_stress[0], 0.0),
            report.crossing,
        )

    def end(self, xp: Namespace, start: StepStart, guess: SweepGuess) -> tuple[Cells, StepReport]:
        """Return all cells together, at the solved fractions."""
        law, element = self.law, self.element
        temperatures = self._settle_temperatures(xp, start, guess)
        free, soft = element.springs(xp, guess.martensite, guess.oriented, temperatures)
        force, carried = element.balance_force(xp, free, soft, self.pull, self.state.force)

        def one(m: Scalar, o: Scalar, at: Scalar, force: Scalar, *flat: Scalar) -> list[Scalar]:
            memory, stress = self.memory(flat), element.wire.stress(xp, force)
            move = law.select(xp, memory, stress, at)
            fractions = law.follow(xp, move, stress, at, self.dt)
            after = law.commit(xp, memory, move, Fractions(m, o), stress, at, self.dt)
            off = xp.maximum(xp.abs(fractions.martensite - m), xp.abs(fractions.oriented - o))
            return [off, *flatten_numbers(after)]

        residuals, *columns = xp.each(one, *guess[:2], temperatures, carried, *self.memories)
        shape = NestedShape(self.state.memories[0])
        memories = tuple(shape.rebuild(flat) for flat in zip(*columns, strict=True))
        ohms, capacity = self._ohms(xp, start, guess)[0], element.heat_capacity_total()
        ripple = self.heating.ripple(xp, ohms, capacity, self.dt)
        report = StepReport(find_largest(xp, residuals), find_largest(xp, guess.crossing), ripple)
        return Cells(memories, force), report

    def _settle_temperatures(self, xp: Namespace, start: StepStart, guess: SweepGuess) -> Column:
        """Return the final temperatures at the solved fractions, conserving heat."""
        imposed = self.heating.temperature
        if imposed is not None:
            return [imposed for _ in start.temperature]
        lines = self.lines(xp, start, guess)

        def settle(r: Scalar, latent: Scalar, x: Scalar, x0: Scalar) -> Scalar:
            return r + latent * (x - x0)

        right = map_rows(xp, settle, lines.right, start.latent, guess.martensite, start.martensite)
        return solve_tridiagonal(xp, lines.diagonal, right, lines.links)


def _average_ends(xp: Namespace, first: Column, last: Column) -> Column:
    def average(a: Scalar, b: Scalar) -> Scalar:
        return 0.5 * (a + b)

    return map_rows(xp, average, first, last)


def _split_exchange(amount: Scalar, rate: Scalar) -> tuple[Scalar, Scalar]:
    """Return the parts of an exchange at the initial and final temperatures."""
    third = amount * rate * (1.0 / 3.0)
    later = amount * ((1.0 + third) / (2.0 + third))
    return amount - later, later
