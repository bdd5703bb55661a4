"""Elements of many cells, each with its own phase state and temperature."""

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
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, find_largest, flatten_numbers, sum_column
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.physics.laws.coupling import StepReport
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.ends import AdiabaticEnds

SWEEPS, HALF_SWEEPS, LAST_SWEEPS = 4, 20, 4
"""Sweeps of a step; where they do not settle it, sweeps that take half of every change, for where
all cells cross a kink together sweeps go to and fro over it; and the last ones."""
SETTLED = 1e-11
"""Change of a fraction in a sweep [-] that counts as zero."""


class AbstractCut(AbstractElement):
    """A wire, or several, as cells; a subclass cuts and links them."""

    wire: Wire

    def require_cells(self) -> None:
        """Raise `ParameterError` unless the cells are plain wires, under a law they can solve."""
        owner, wire = self.registered_name, self.wire
        if wire.registered_name != Wire.registered_name:
            raise ParameterError(f"Element `{owner}` is made of `wire`, but holds `{wire.registered_name}`.")
        if not isinstance(wire.ends, AdiabaticEnds):
            raise ParameterError(
                f"The `wire` of `{owner}` must have `adiabatic` ends, but they are `{wire.ends.registered_name}`."
            )
        if wire.wear is not None:
            raise ParameterError(f"The `wire` of `{owner}` must have no `wear`; take a lumped one, such as `wire`.")
        if wire.law.grouped:
            raise ParameterError(
                f"Law `{wire.law.registered_name}` has its own groups, which a `{owner}` "
                "cannot divide further; try law `mas`."
            )
        if wire.law.rphase:
            raise ParameterError(
                f"Law `{wire.law.registered_name}` has three phases, but the cells of a `{owner}` solve for two; "
                "take a plain `wire`."
            )

    @property
    def law(self) -> AbstractLaw:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return the law of the wire."""
        return self.wire.law

    @property
    def limits(self) -> ElementLimits:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return the limits of the wire."""
        return self.wire.limits

    def copies(self) -> Scalar:
        """Return the number of equal rows of cells in the element, end to end."""
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
        """Return the parts of the current that flow through the cells."""
        return [1.0 for _ in self.lengths(xp)]

    def linkage(self) -> Linkage:
        """Return how the cells share force and elongation."""
        return EndToEnd(self.copies())

    def force_on_cells(self, state: Cells) -> Column:
        """Return the force on each cell at the end of the last step [N]."""
        area = self.wire.section()
        return [memory.stress * area for memory in state.memories]

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
        """Return the force [N] at which cells and mechanism fit, from one nearby; and that on each cell."""
        linkage = self.linkage()

        def near(xp: Namespace, force: Scalar) -> Spring:
            return linkage.whole(xp, free, soft, force)

        force = equilibrium_force(xp, near, pull, force, self.passes)
        return force, self.force_share(xp, free, soft, force)

    def force_share(self, xp: Namespace, free: Column, soft: Column, force: Scalar) -> Column:
        """Return the part of a force [N] that each cell carries."""
        linkage = self.linkage()
        whole = linkage.whole(xp, free, soft, force)
        own = [Spring(*pair) for pair in zip(free, soft, strict=True)]
        return [linkage.force_share(xp, one, whole, force) for one in own]


class AbstractCells(AbstractCut):
    """Cells that share force and current, with heat between neighbours."""

    def init(self, xp: Namespace, force: Scalar, temperature: Scalar) -> Cells:
        """Return the state at the start, under `force` [N] and at `temperature` [K]."""
        memory = self.wire.init(xp, force, temperature).memory
        return Cells((memory,) * len(self.lengths(xp)), force)

    def force(self, state: Cells) -> Scalar:
        """Return the force at the end of the last step [N]."""
        return state.force

    def tangent(self, xp: Namespace, state: Cells, force: Scalar) -> Spring:
        """Return all cells as one spring, near a force [N]."""
        return self.linkage().whole(xp, *self.springs(xp, *self._columns(state)), force)

    def profile(self, state: Cells) -> CellProfile:
        """Return the temperature and martensite fraction of every cell."""
        m, _, temperatures = self._columns(state)
        return CellProfile(temperatures, m)

    def points(self, xp: Namespace, state: Cells) -> list[MaterialPoint]:
        """Every cell, unless the law has rates."""
        return points_of(xp, self.law, state.memories)

    def _columns(self, state: Cells) -> tuple[Column, Column, Column]:
        fractions = [self.law.fractions(memory) for memory in state.memories]
        m, o = [f.martensite for f in fractions], [f.oriented for f in fractions]
        return m, o, [memory.temperature for memory in state.memories]

    def advance(
        self, xp: Namespace, state: Cells, heating: Heating, pull: Pull, dt: Scalar
    ) -> tuple[Cells, StepReport]:
        """Return the state after a step of dt [s], and the report of the step."""
        step = SweepStep(self, state, heating, pull, dt)
        start = step.start(xp)
        guess = step.guess_without_transformation(start)
        shape = NestedShape(guess)

        def turn(_: Scalar, turned: Scalar, *numbers: Scalar) -> list[Scalar]:
            before = shape.rebuild(numbers)
            after = step.sweep(xp, start, before)
            pairs = zip(after.martensite, before.martensite, strict=True)
            moved = find_largest(xp, [xp.abs(a - b) for a, b in pairs])
            halved = xp.both(turned > SWEEPS - 0.5, turned < SWEEPS + HALF_SWEEPS - 0.5)
            share = xp.where(halved, 0.5, 1.0)
            now = [b + share * (a - b) for a, b in zip(flatten_numbers(after), numbers, strict=True)]
            return [xp.where(moved > SETTLED, 1.0, 0.0), turned + 1.0, *now]

        most = SWEEPS + HALF_SWEEPS + LAST_SWEEPS
        _, _, *numbers = xp.iterate(most, turn, 1.0, 0.0, *flatten_numbers(guess))
        return step.end(xp, start, shape.rebuild(numbers))

    def condition(self, xp: Namespace, state: Cells, force: Scalar, environment: Environment) -> Condition:
        """Everything that can be measured on the element under a force [N]."""
        lengths, (m, o, temperatures) = self.lengths(xp), self._columns(state)
        free, soft = self.springs(xp, m, o, temperatures)
        carried = self.force_share(xp, free, soft, force)
        stresses = [self.wire.stress(xp, each) for each in carried]

        def one(length: Scalar, m: Scalar, o: Scalar, at: Scalar, stress: Scalar, share: Scalar) -> tuple[Scalar, ...]:
            cell, strain = self.cell(length), self.law.strain(xp, Fractions(m, o), stress, at)
            ohms = cell.ohms(xp, m, strain, at)
            return cell.heat_loss(xp, at, environment), share * ohms

        columns = lengths, m, o, temperatures, stresses, self.shares(xp)
        losses, ohms = xp.each(one, *columns)
        outside = self.links(xp, m).outside
        ambient = environment.temperature
        drained = [g * (t - ambient) for g, t in zip(outside, temperatures, strict=True)]
        per_length = 1.0 / sum_column(lengths)

        def mean(column: Column) -> Scalar:
            return per_length * sum_column([w * v for w, v in zip(lengths, column, strict=True)])

        return Condition(
            temperature=mean(temperatures),
            hottest=find_largest(xp, temperatures),
            martensite_fraction=mean(m),
            oriented_fraction=mean(o),
            stress=find_largest(xp, stresses),
            strain=self.elongation(xp, state, force) * (1.0 / self.wire.length),
            resistance=self.copies() * sum_column(ohms),
            heat_loss=self.copies() * (sum_column(losses) + sum_column(drained)),
        )

    def stored_heat(self, xp: Namespace, state: Cells) -> StoredHeat:
        """C T of all cells, and λ along the martensite fraction of each."""
        fractions, _, temperatures = self._columns(state)

        def one(length: Scalar, at: Scalar, stress: Scalar) -> tuple[Scalar, Scalar]:
            cell = self.cell(length)
            held = cell.heat_capacity_total() * at
            return held, -cell.latent_heat_total(xp, stress, at)

        stresses = [memory.stress for memory in state.memories]
        held, latent = xp.each(one, self.lengths(xp), temperatures, stresses)
        efforts = [Effort(self.copies() * h, x) for h, x in zip(latent, fractions, strict=True)]
        if self.law.constant_heat:  # then the energy itself is known, which takes one number
            efforts = [Effort(1.0, sum_column([h * x for h, x in efforts]))]
        return StoredHeat(self.copies() * sum_column(held), tuple(efforts))

    def elastic_energy(self, xp: Namespace, state: Cells) -> Scalar:
        """½ compliance · force² of all cells [J]."""
        free, soft = self.springs(xp, *self._columns(state))
        carried = self.force_share(xp, free, soft, state.force)
        rows = zip(soft, carried, strict=True)
        return self.copies() * sum_column([0.5 * c * each * each for c, each in rows])

    def heat_capacity_total(self) -> Scalar:
        """Return the heat capacity without transformation [J/K]."""
        return self.wire.heat_capacity_total()

    def heat_loss(self, xp: Namespace, temperature: Scalar, environment: Environment) -> Scalar:
        """Return the heat flow through the surface [W] if all cells are equally hot."""
        return self.wire.heat_loss(xp, temperature, environment)
