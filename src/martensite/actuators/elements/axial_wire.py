"""Axial wire: heat conduction along a wire, with a phase state and temperature per cell.

    ρ c ∂T/∂t = ∂/∂y (k ∂T/∂y) + ρ λ ∂ξ/∂t - (4/d) h (T - T_a) + j²ρ_el
    1/k = (1 - ξ)/k_A + ξ/k_M

under one force, between clamps at ambient temperature that take G_c (T - T_a) each. Clamps divide the wire into `spans`
equal lengths; half a span is cut into cells (finite volumes), narrower towards the clamp, and represents all of them.
Second order in the cells. The healing length √(k d/(4 h)), some millimetres, is the range of a clamp.

Cell faces lie at y = ℓ (e^{γ s} - 1)/(e^γ - 1), s = 0, 1/N … 1 from the clamp to the middle.
"""

from itertools import accumulate, pairwise

from martensite.actuators.elements.base import ELEMENTS
from martensite.actuators.elements.cells import AbstractCells
from martensite.actuators.elements.columns import Links
from martensite.actuators.elements.network import Column
from martensite.actuators.elements.wire import Wire
from martensite.base.interfaces import override
from martensite.base.parameters import FROM_MATERIAL, Number, option, param, part
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import map_rows


@ELEMENTS.register("axial-wire")
class AxialWire(AbstractCells):
    """Wire that is cooler near its clamps."""

    thermal_conductivity: Number = param(
        "W/m/K", "thermal conductivity of austenite", above=0.0, high=1e9, default=FROM_MATERIAL, typical="15 W/m/K"
    )
    conductivity_ratio: Number = param(
        "1", "thermal conductivity of martensite over that of austenite", above=0.0, high=100.0, default=1.0
    )
    contact: Number = param(
        "W/K", "contact conductance between clamp and end of a span", low=0.0, high=1e9, default=1e3
    )
    spans: Number = param("1", "spans between clamps", low=1.0, high=1e4, default=1.0, typical=2.0)
    grading: Number = param(
        "1", "how much narrower cells get towards a clamp (the exponent γ)", above=0.0, high=15.0, default=4.0
    )
    cells: str = option("cells per half span", "5", "10", "20", "40", "80", default="20")
    wire: Wire = part("the wire that is cut", ELEMENTS)

    @override
    def check(self) -> None:
        self.require_cells()

    @override
    def copies(self) -> Scalar:
        return 2.0 * self.spans

    def lengths(self, xp: Namespace) -> Column:
        """Return the lengths of the cells from the clamp to the middle of a span [m]."""
        count = int(self.cells)
        faces = [xp.exp(self.grading * (k / count)) for k in range(count + 1)]
        scale = self.wire.length / (self.copies() * (faces[-1] - 1.0))
        return [scale * (b - a) for a, b in pairwise(faces)]

    @override
    def places(self) -> list[float]:
        lengths = self.lengths(floats)
        ends = [0.0, *accumulate(lengths)]
        return [0.5 * (a + b) for a, b in pairwise(ends)]

    def links(self, xp: Namespace, fractions: Column) -> Links:
        """Return the conductances between cells, and from the first cell to the clamp [W/K]."""
        along = self.thermal_conductivity * self.wire.section()
        less = 1.0 / self.conductivity_ratio - 1.0

        def resist(length: Scalar, x: Scalar) -> Scalar:
            return 0.5 * length * (1.0 + less * x) / along  # [K/W]

        def join(a: Scalar, b: Scalar) -> Scalar:
            return 1.0 / (a + b)

        halves = map_rows(xp, resist, self.lengths(xp), fractions)
        between = map_rows(xp, join, halves[:-1], halves[1:])
        clamp = self.contact / (1.0 + self.contact * halves[0])
        return Links(between, [clamp] + [0.0] * len(between))
