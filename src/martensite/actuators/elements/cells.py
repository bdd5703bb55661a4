"""Elements of many cells, each with its own phase state and temperature."""

import operator
from abc import abstractmethod

from martensite.actuators.elements.base import (
    AbstractElement,
    CellProfile,
    Condition,
    Effort,
    Heating,
    MaterialPoint,
    Pull,
    Spring,
    StoredHeat,
    equilibrium_force,
    points_of,
)
from martensite.actuators.elements.columns import Cells, Links
from martensite.actuators.elements.limits import ElementLimits
from martensite.actuators.elements.network import Column, EndToEnd, Linkage
from martensite.actuators.elements.sweeps import SweepStep
from martensite.actuators.elements.wire import Wire
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, find_largest, flatten_numbers, map_rows, sum_column, sum_columns
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.physics.laws.coupling import StepReport
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.ends import AdiabaticEnds

SWEEPS, HALF_SWEEPS, LAST_SWEEPS = 4, 20, 4
"""Sweeps of a step; then sweeps that may take half of each change, against oscillations over a kink; then the last."""
FALLING = 0.25
"""Ratio of a change to the previous change, up to which sweeps converge and take the whole change."""
SETTLED = 1e-11
"""Change of a fraction in a sweep [-] that counts as zero."""


class AbstractCut(AbstractElement):
    """One or several wires cut into cells; subclasses cut and link them."""

    wire: Wire

    def require_cells(self) -> None:
        """Raise `ParameterError` unless the cells are plain wires with a suitable law."""
        owner, wire = self.registered_name, self.wire
        if wire.registered_name != Wire.registered_name:
            raise ParameterError(f"Element `{owner}` is made of `wire`, but holds `{wire.registered_name}`.")
        if not isinstance(wire.ends, AdiabaticEnds):
            raise ParameterError(
                f"The `wire` of `{owner}` must have `adiabatic` ends, but they are `{wire.ends.registered_name}`."
            )
        if wire.wear is not None:
            raise ParameterError(f"The `wire` of `{owner}` must have no `wear`; take a lumped one, such as `wire`.")
        if wire.law.has_groups:
            raise ParameterError(
                f"Law `{wire.law.registered_name}` has its own groups, which a `{owner}` "
                "cannot divide further; try law `mas`."
            )
        if wire.law.has_rphase:
            raise ParameterError(
                f"Law `{wire.law.registered_name}` has three phases, but the cells of a `{owner}` solve for two; "
                "take a plain `wire`."
            )

    @property
    def law(self) -> AbstractLaw:  # pyrefly: ignore[bad-override]
        """Return the law of the wire."""
        return self.wire.law

    @property
    def limits(self) -> ElementLimits:  # pyrefly: ignore[bad-override]
        """Return the limits of the wire."""
        return self.wire.limits

    def copies(self) -> Scalar:
        """Return the number of equal rows of cells, end to end."""
        return 1.0

    @abstractmethod
    def lengths(self, xp: Namespace) -> Column:
        """Return the lengths of the cells of one row [m]."""

    @abstractmethod
    def links(self, xp: Namespace, fractions: Column) -> Links:
        """Return the conductances between cells at given martensite fractions."""

    def cell(self, length: Scalar) -> Wire:
        """Return a piece of the wire."""
        return self.wire.rebuilt({"length": length})

    def shares(self, xp: Namespace) -> Column:
        """Return the fraction of the current through each cell."""
        return [1.0 for _ in self.lengths(xp)]

    def linkage(self) -> Linkage:
        """Return how the cells share force and elongation."""
        return EndToEnd(self.copies())

    def force_on_cells(self, xp: Namespace, state: Cells) -> Column:
        """Return the force on each cell at the end of the last step [N]."""
        area = self.wire.section()
        return map_rows(xp, operator.mul, [memory.stress for memory in state.memories], [area] * len(state.memories))

    def springs(
        self, xp: Namespace, martensite: Column, oriented: Column, temperatures: Column
    ) -> tuple[Column, Column]:
        """Return free elongations [m] and compliances [m/N] of the cells."""

        def one(length: Scalar, m: Scalar, o: Scalar, temperature: Scalar) -> tuple[Scalar, Scalar]:
            return self.cell(length).spring(xp, Fractions(m, o), temperature, 0.0)

        free, soft = xp.each(one, self.lengths(xp), martensite, oriented, temperatures)
        return free, soft

    def balance_force(
        self, xp: Namespace, free: Column, soft: Column, pull: Pull, force: Scalar
    ) -> tuple[Scalar, Column]:
        """Return the equilibrium force [N] of cells and mechanism, and the force on each cell."""
        linkage = self.linkage()

        def near(xp: Namespace, force: Scalar) -> Spring:
            return linkage.whole(xp, free, soft, force)

        force = equilibrium_force(xp, near, pull, force, self.passes)
        return force, self.force_share(xp, free, soft, force)

    def force_share(self, xp: Namespace, free: Column, soft: Column, force: Scalar) -> Column:
        """Return the part of a force [N] on each cell."""
        linkage = self.linkage()
        whole = linkage.whole(xp, free, soft, force)
        own = [Spring(*pair) for pair in zip(free, soft, strict=True)]
        return [linkage.force_share(xp, one, whole, force) for one in own]


class AbstractCells(AbstractCut):
    """Cells that share force and current, with heat exchange between neighbours."""

    @override
    def init(self, xp: Namespace, force: Scalar, temperature: Scalar) -> Cells:
        memory = self.wire.init(xp, force, temperature).memory
        return Cells((memory,) * len(self.lengths(xp)), force)

    @override
    def force(self, state: Cells) -> Scalar:
        return state.force

    @override
    def tangent(self, xp: Namespace, state: Cells, force: Scalar) -> Spring:
        return self.linkage().whole(xp, *self.springs(xp, *self._columns(state)), force)

    @override
    def profile(self, state: Cells) -> CellProfile:
        m, _, temperatures = self._columns(state)
        return CellProfile(temperatures, m)

    @override
    def points(self, xp: Namespace, state: Cells) -> list[MaterialPoint]:
        return points_of(xp, self.law, state.memories)

    def _columns(self, state: Cells) -> tuple[Column, Column, Column]:
        fractions = [self.law.fractions(memory) for memory in state.memories]
        m, o = [f.martensite for f in fractions], [f.oriented for f in fractions]
        return m, o, [memory.temperature for memory in state.memories]

    @override
    def advance(
        self, xp: Namespace, state: Cells, heating: Heating, pull: Pull, dt: Scalar
    ) -> tuple[Cells, StepReport]:
        step = SweepStep(self, state, heating, pull, dt)
        start = step.start(xp)
        guess = step.guess_without_transformation(xp, start)
        shape = NestedShape(guess)

        def change(a: Scalar, b: Scalar) -> Scalar:
            return xp.abs(a - b)

        def turn(_: Scalar, turned: Scalar, last: Scalar, *numbers: Scalar) -> list[Scalar]:
            before = shape.rebuild(numbers)
            after = step.sweep(xp, start, before)
            moved = find_largest(xp, map_rows(xp, change, after.martensite, before.martensite))
            middle = xp.both(turned > SWEEPS - 0.5, turned < SWEEPS + HALF_SWEEPS - 0.5)
            share = xp.where(xp.both(middle, moved > FALLING * last), 0.5, 1.0)
            now = [b + share * (a - b) for a, b in zip(flatten_numbers(after), numbers, strict=True)]
            return [xp.where(moved > SETTLED, 1.0, 0.0), turned + 1.0, moved, *now]

        most = SWEEPS + HALF_SWEEPS + LAST_SWEEPS
        _, _, _, *numbers = xp.iterate(most, turn, 1.0, 0.0, 0.0, *flatten_numbers(guess))
        return step.end(xp, start, shape.rebuild(numbers))

    @override
    def condition(self, xp: Namespace, state: Cells, force: Scalar, environment: Environment) -> Condition:
        lengths, (m, o, temperatures) = self.lengths(xp), self._columns(state)
        free, soft = self.springs(xp, m, o, temperatures)
        carried = self.force_share(xp, free, soft, force)
        stresses = [self.wire.stress(xp, each) for each in carried]

        def one(length: Scalar, m: Scalar, o: Scalar, at: Scalar, stress: Scalar, share: Scalar) -> tuple[Scalar, ...]:
            cell, strain = self.cell(length), self.law.strain(xp, Fractions(m, o), stress, at)
            ohms = cell.ohms(xp, m, strain, at)
            return cell.heat_loss(xp, at, environment), share * ohms

        columns = lengths, m, o, temperatures, stresses, self.shares(xp)
        lost, resistance = sum_columns(xp, *xp.each(one, *columns))
        outside = self.links(xp, m).outside
        ambient = environment.temperature
        drained = [g * (t - ambient) for g, t in zip(outside, temperatures, strict=True)]
        per_length = 1.0 / sum_column(lengths)

        def mean(column: Column) -> Scalar:
            return per_length * sum_columns(xp, [w * v for w, v in zip(lengths, column, strict=True)])[0]

        return Condition(
            temperature=mean(temperatures),
            hottest=find_largest(xp, temperatures),
            martensite_fraction=mean(m),
            oriented_fraction=mean(o),
            stress=find_largest(xp, stresses),
            strain=self.elongation(xp, state, force) * (1.0 / self.wire.length),
            resistance=self.copies() * resistance,
            heat_loss=self.copies() * (lost + sum_column(drained)),
        )

    @override
    def stored_heat(self, xp: Namespace, state: Cells) -> StoredHeat:
        fractions, _, temperatures = self._columns(state)

        def one(length: Scalar, at: Scalar, stress: Scalar) -> tuple[Scalar, Scalar]:
            cell = self.cell(length)
            sensible = cell.heat_capacity_total() * at
            return sensible, -cell.latent_heat_total(xp, stress, at)

        stresses = [memory.stress for memory in state.memories]
        sensible, latent = xp.each(one, self.lengths(xp), temperatures, stresses)
        efforts = [Effort(self.copies() * h, x) for h, x in zip(latent, fractions, strict=True)]
        if self.law.constant_heat:  # the energy itself, as one number
            efforts = [Effort(1.0, *sum_columns(xp, [h * x for h, x in efforts]))]
        return StoredHeat(self.copies() * sum_columns(xp, sensible)[0], tuple(efforts))

    @override
    def elastic_energy(self, xp: Namespace, state: Cells) -> Scalar:
        free, soft = self.springs(xp, *self._columns(state))
        carried = self.force_share(xp, free, soft, state.force)
        rows = zip(soft, carried, strict=True)
        return self.copies() * sum_columns(xp, [0.5 * c * each * each for c, each in rows])[0]

    @override
    def heat_capacity_total(self) -> Scalar:
        return self.wire.heat_capacity_total()

    @override
    def heat_loss(self, xp: Namespace, temperature: Scalar, environment: Environment) -> Scalar:
        return self.wire.heat_loss(xp, temperature, environment)
