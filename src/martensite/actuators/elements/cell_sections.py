"""What an element of many cells says about itself: its pieces, and what links them."""

from __future__ import annotations

from abc import abstractmethod

from martensite.actuators.elements.base import AbstractElement, Pull, Spring, equilibrium_force
from martensite.actuators.elements.columns import Cells, Links
from martensite.actuators.elements.limits import ElementLimits
from martensite.actuators.elements.linkage import EndToEnd, Linkage
from martensite.actuators.elements.network import Column
from martensite.actuators.elements.wire import Wire
from martensite.base.errors import ParameterError
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.base import AbstractLaw, Fractions
from martensite.physics.thermal.ends import AdiabaticEnds


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
        if wire.law.grouped:
            raise ParameterError(
                f"Law `{wire.law.registered_name}` has groups of its own, which a `{owner}` "
                "cannot divide further; try law `mas`."
            )

    @property
    def law(self) -> AbstractLaw:  # pyright: ignore[reportIncompatibleVariableOverride]
        """The law of the wire."""
        return self.wire.law

    @property
    def limits(self) -> ElementLimits:  # pyright: ignore[reportIncompatibleVariableOverride]
        """The limits of the wire."""
        return self.wire.limits

    def copies(self) -> Scalar:
        """How many equal rows of cells the element has, end to end."""
        return 1.0

    @abstractmethod
    def lengths(self, xp: Namespace) -> Column:
        """Lengths of the cells of one row [m]."""

    @abstractmethod
    def links(self, xp: Namespace, fractions: Column) -> Links:
        """What conducts heat at given martensite fractions."""

    def cell(self, length: Scalar) -> Wire:
        """A piece of the wire."""
        return self.wire.rebuilt({"length": length})

    def shares(self, xp: Namespace) -> Column:
        """Parts of the current that flow through the cells."""
        return [1.0 for _ in self.lengths(xp)]

    def linkage(self) -> Linkage:
        """How the cells share force and elongation."""
        return EndToEnd(self.copies())

    def force_on_cells(self, state: Cells) -> Column:
        """Force on each cell at the end of the last step [N]."""
        area = self.wire.section()
        return [memory.stress * area for memory in state.memories]

    def springs(
        self, xp: Namespace, martensite: Column, oriented: Column, temperatures: Column
    ) -> tuple[Column, Column]:
        """Free elongations [m] and compliances [m/N] of the cells."""

        def one(length: Scalar, m: Scalar, o: Scalar, temperature: Scalar) -> tuple[Scalar, Scalar]:
            return self.cell(length).spring(xp, Fractions(m, o), temperature, 0.0)

        free, soft = xp.each(one, self.lengths(xp), martensite, oriented, temperatures)
        return free, soft

    def balance_force(
        self, xp: Namespace, free: Column, soft: Column, pull: Pull, force: Scalar
    ) -> tuple[Scalar, Column]:
        """Force [N] at which cells and mechanism fit, from one nearby; and that on each cell."""
        linkage = self.linkage()

        def near(xp: Namespace, force: Scalar) -> Spring:
            return linkage.whole(xp, free, soft, force)

        force = equilibrium_force(xp, near, pull, force, self.passes)
        return force, self.force_share(xp, free, soft, force)

    def force_share(self, xp: Namespace, free: Column, soft: Column, force: Scalar) -> Column:
        """What each cell carries of a force [N]."""
        linkage = self.linkage()
        whole = linkage.whole(xp, free, soft, force)
        own = [Spring(*pair) for pair in zip(free, soft, strict=True)]
        return [linkage.force_share(xp, one, whole, force) for one in own]
