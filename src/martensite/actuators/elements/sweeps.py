"""One step of an element of many cells.

Cells share force and current; heat flows between neighbours. A step sweeps over them: each cell solves its own coupled
step in a bracket (`laws.coupling`), with all others as a linear heat balance and a spring (`elements.network`) from the
previous sweep. This is Newton's method for the others and a bracket for the cell itself; the remaining mismatch is the
residual of the step.

The flux between two cells is weighted between start and end of the step by θ = (1 + z/3)/(2 + z/3), z = dt G (1/C_i +
1/C_j): trapezoidal for slow exchange, implicit for fast exchange. Second order, without ringing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from martensite.actuators.elements.base import Heating, Pull
from martensite.actuators.elements.columns import Cells, HeatBalanceColumns, StepStart, SweepGuess
from martensite.actuators.elements.heat_steps import compute_relaxation
from martensite.actuators.elements.network import Column, Rest, fold_others, solve_tridiagonal
from martensite.kernels.dual import value_and_slope, values_and_slopes
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, find_largest, flatten_numbers, sum_column
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

    def guess_without_transformation(self, start: StepStart) -> SweepGuess:
        """Return the guess without transformation."""
        none = [0.0 for _ in start.long]
        columns = (
            start.martensite,
            start.oriented,
            start.temperature,
            self.element.force_on_cells(self.state),
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
        middle = _average_ends(start.martensite, guess.martensite)
        joule = self._joule(xp, start, guess)
        links, ambient = self.element.links(xp, middle), self.heating.environment.temperature
        diagonal = list(start.diagonal)
        right = [a + b for a, b in zip(start.right, joule, strict=True)]
        t, c, between = start.temperature, start.capacity, list[Scalar]()
        for i, g in enumerate(links.outside):
            now, later = _split_exchange(self.dt * g, 1.0 / c[i])
            diagonal[i] = diagonal[i] + later
            right[i] = right[i] + later * ambient + now * (ambient - t[i])
        for i, g in enumerate(links.between):
            now, later = _split_exchange(self.dt * g, 1.0 / c[i] + 1.0 / c[i + 1])
            flow = now * (t[i + 1] - t[i])
            right[i], right[i + 1] = right[i] + flow, right[i + 1] - flow
            between.append(later)
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
            _average_ends(start.martensite, guess.martensite),
            element.shares(xp),
            start.temperature,
            guess.temperature,
            start.long,
            guess.long,
        )
        seen, heated = xp.each(one, *columns)
        return element.copies() * sum_column(seen), heated

    def sweep(self, xp: Namespace, start: StepStart, guess: SweepGuess) -> SweepGuess:
        """Return each cell solved alone, with the others from the previous sweep."""
        lines = self.lines(xp, start, guess)
        diagonal = [d + w for d, w in zip(lines.diagonal, guess.warms, strict=True)]
        seen = fold_others(diagonal, self._expect_latent_heat(start, guess, lines), lines.links)
        felt = fold_others(diagonal, guess.gives, lines.links)
        rests = self._rests(xp, guess, solve_tridiagonal(diagonal, guess.gives, lines.links))

        def one(*row: Scalar) -> tuple[Scalar, ...]:
            return self._solve_cell(xp, row)

        rows = xp.each(
            one,
            self.element.lengths(xp),
            start.martensite,
            start.latent,
            [d + b for d, b in zip(lines.diagonal, seen.slope, strict=True)],
            [r + s for r, s in zip(lines.right, seen.source, strict=True)],
            felt.source,
            guess.force,
            *rests,
            *self.memories,
        )
        return SweepGuess(*(tuple(column) for column in rows))

    def _expect_latent_heat(self, start: StepStart, guess: SweepGuess, lines: HeatBalanceColumns) -> list[Scalar]:
        """Return the right-hand side with latent heat linearised in temperature [J]."""
        rows = zip(
            lines.right, start.latent, guess.martensite, start.martensite, guess.warms, guess.temperature, strict=True
        )
        return [r + latent * (x - x0) + w * t for r, latent, x, x0, w, t in rows]

    def _rests(self, xp: Namespace, guess: SweepGuess, heated: Column) -> tuple[Column, Column]:
        """Return the others as springs; more force on all of them also heats them [K/N]."""
        rows = zip(guess.soft, guess.shrinks, heated, guess.elastic, strict=True)
        soft = [xp.maximum(c + s * h, e) for c, s, h, e in rows]
        long = zip(guess.long, soft, guess.force, strict=True)
        free = [e - c * f for e, c, f in long]
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
        rows = zip(lines.right, start.latent, guess.martensite, start.martensite, strict=True)
        right = [r + latent * (x - x0) for r, latent, x, x0 in rows]
        return solve_tridiagonal(lines.diagonal, right, lines.links)


def _average_ends(first: Column, last: Column) -> list[Scalar]:
    return [0.5 * (a + b) for a, b in zip(first, last, strict=True)]


def _split_exchange(amount: Scalar, rate: Scalar) -> tuple[Scalar, Scalar]:
    """Return the parts of an exchange at the initial and final temperatures."""
    third = amount * rate * (1.0 / 3.0)
    later = amount * ((1.0 + third) / (2.0 + third))
    return amount - later, later
