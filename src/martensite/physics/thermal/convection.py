"""Convection from a heated cylinder in a fluid, free or forced.

    h = Nu k/s          Ra = g β |T - T_a| s³/(ν α)

with all properties at the film temperature (T + T_a)/2 and the size s of the correlation (diameter or length). Powers
of Ra below one have an infinite slope at T = T_a, so |T - T_a| is at least 0.01 K.
"""

from abc import abstractmethod

from martensite.base.interfaces import override
from martensite.base.parameters import Number, param, part
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.fluids.air import Air
from martensite.physics.fluids.base import FLUIDS, AbstractFluid, FluidProperties
from martensite.physics.thermal.base import COOLING, AbstractCooling, Cylinder

LEAST_DIFFERENCE = 0.01
"""Smallest |T - T_a| that drives the flow [K]."""


def raise_constant(xp: Namespace, base: Scalar, exponent: Scalar) -> Scalar:
    """Return a nonnegative `base` to a constant power."""
    return xp.exp(exponent * xp.log(base))


class AbstractFreeConvection(AbstractCooling):
    """Correlation Nu(Ra, Pr) with fluid and gravity."""

    fluid: AbstractFluid = part("fluid around the element", FLUIDS, default=Air())
    gravity: Number = param("m/s^2", "acceleration of gravity", low=0.0, high=100.0, default=9.80665)

    @override
    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        fluid = self.fluid.properties(xp, 0.5 * (temperature + ambient))
        size = self.size(shape)
        rayleigh = self.rayleigh(xp, fluid, xp.abs(temperature - ambient), size)
        return self.nusselt(xp, rayleigh, fluid.prandtl, shape) * fluid.conductivity / size

    def rayleigh(self, xp: Namespace, fluid: FluidProperties, difference: Scalar, size: Scalar) -> Scalar:
        """Return Ra [-] of a body of this size [m] at a temperature `difference` [K]."""
        driving = self.gravity * fluid.expansion * xp.maximum(difference, LEAST_DIFFERENCE)
        return driving * size * size * size / (fluid.viscosity * fluid.diffusivity)

    def size(self, shape: Cylinder) -> Scalar:
        """Return the size s [m] of Nu and Ra."""
        return shape.diameter

    @abstractmethod
    def nusselt(self, xp: Namespace, rayleigh: Scalar, prandtl: Scalar, shape: Cylinder) -> Scalar:
        """Return the mean Nusselt number h s/k [-]."""


@COOLING.register("churchill-chu")
class ChurchillChu(AbstractFreeConvection):
    """Free convection from a horizontal wire, one smooth curve.

        Nu = {0.60 + 0.387 Ra^(1/6)/[1 + (0.559/Pr)^(9/16)]^(8/27)}²

    on the diameter, for Ra from 1e-5 to 1e12, laminar and turbulent. In still air it agrees with `morgan` for wires
    near 0.2 mm; 60 K above ambient it is 11 % lower at 0.381 mm, 19 % lower at 1 mm and 11 % higher at 0.038 mm.

    Source: Churchill and Chu (1975); the equation of textbooks, recalled.
    """

    cites = ("churchill1975",)

    @override
    def nusselt(self, xp: Namespace, rayleigh: Scalar, prandtl: Scalar, shape: Cylinder) -> Scalar:
        damping = raise_constant(xp, 1.0 + raise_constant(xp, 0.559 / prandtl, 9.0 / 16.0), 8.0 / 27.0)
        root = 0.60 + 0.387 * raise_constant(xp, rayleigh, 1.0 / 6.0) / damping
        return root * root


LAWS = ((0.675, 0.058), (1.02, 0.148), (0.850, 0.188), (0.480, 0.250), (0.125, 0.333))
"""(C, n) of Nu = C Raⁿ, in the order of rising Ra."""


@COOLING.register("morgan")
class Morgan(AbstractFreeConvection):
    """Free convection from a horizontal wire, five power laws.

    | Ra | Nu |
    | --- | --- |
    | 1e-10 to 1e-2 | 0.675 Ra^0.058 |
    | 1e-2 to 1e2 | 1.02 Ra^0.148 |
    | 1e2 to 1e4 | 0.850 Ra^0.188 |
    | 1e4 to 1e7 | 0.480 Ra^0.250 |
    | 1e7 to 1e12 | 0.125 Ra^0.333 |

    on the diameter. The exponents rise, so each law is the largest in its own range, and Nu here is the largest of the
    five: the table without its jumps. At the printed limits neighbours differ by 0.2 %, 0.2 %, less than 0.1 % and 0.8
    %; they meet at Ra = 1.02e-2, 95, 1.01e4 and 1.10e7 instead.

    Source: Morgan (1975); the table of textbooks, recalled.
    """

    cites = ("morgan1975",)

    @override
    def nusselt(self, xp: Namespace, rayleigh: Scalar, prandtl: Scalar, shape: Cylinder) -> Scalar:
        log = xp.log(rayleigh)
        number = LAWS[0][0] * xp.exp(LAWS[0][1] * log)
        for factor, exponent in LAWS[1:]:
            number = xp.maximum(number, factor * xp.exp(exponent * log))
        return number


@COOLING.register("lefevre-ede")
class LeFevreEde(AbstractFreeConvection):
    """Free convection from a vertical wire.

        Nu = (4/3) {7 Ra Pr/[5 (20 + 21 Pr)]}^(1/4) + 4 (272 + 315 Pr) l/[35 (64 + 63 Pr) d]

    on the length l, for laminar flow. The second term is the curvature. For a wire it is most of h, which then hardly
    depends on l; without it h would be the several times smaller value of a plate.

    The wire must hang vertically; for a horizontal wire use `churchill-chu` or `morgan`. The series in the curvature
    has two terms, so a long thin wire is at the end of its range. Source: LeFevre and Ede (1956), as printed by
    Kossoski (2018), eq. (3.2).
    """

    cites = ("lefevre-ede", "kossoski2018")

    @override
    def size(self, shape: Cylinder) -> Scalar:
        return shape.length

    @override
    def nusselt(self, xp: Namespace, rayleigh: Scalar, prandtl: Scalar, shape: Cylinder) -> Scalar:
        plate = 7.0 * rayleigh * prandtl / (5.0 * (20.0 + 21.0 * prandtl))
        slenderness = shape.length / shape.diameter
        curvature = 4.0 * (272.0 + 315.0 * prandtl) / (35.0 * (64.0 + 63.0 * prandtl))
        return 4.0 / 3.0 * xp.sqrt(xp.sqrt(plate)) + curvature * slenderness


@COOLING.register("churchill-bernstein")
class ChurchillBernstein(AbstractCooling):
    """Forced convection from a wire across a stream.

        Nu = 0.3 + 0.62 √Re Pr^(1/3)/[1 + (0.4/Pr)^(2/3)]^(1/4) · [1 + (Re/282000)^(5/8)]^(4/5)

    on the diameter, Re = u d/ν, for Re Pr above 0.2; properties at the film temperature. The stream is at ambient
    temperature and perpendicular to the wire. Buoyancy is not included: the formula is invalid if free convection would
    be as large.

    Source: Churchill and Bernstein (1977); the equation of textbooks, recalled.
    """

    cites = ("churchill1977",)

    speed: Number = param("m/s", "speed of the stream across the wire", above=0.0, high=100.0, typical="1 m/s")
    fluid: AbstractFluid = part("fluid around the element", FLUIDS, default=Air())

    @override
    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        fluid = self.fluid.properties(xp, 0.5 * (temperature + ambient))
        reynolds = self.speed * shape.diameter / fluid.viscosity
        return self.nusselt(xp, reynolds, fluid.prandtl) * fluid.conductivity / shape.diameter

    def nusselt(self, xp: Namespace, reynolds: Scalar, prandtl: Scalar) -> Scalar:
        """Return the mean Nusselt number on the diameter [-]."""
        return STILL_NUSSELT + correlate_stream(xp, reynolds, prandtl)


STILL_NUSSELT = 0.3
"""Nu of `churchill-bernstein` without flow."""


def correlate_stream(xp: Namespace, reynolds: Scalar, prandtl: Scalar) -> Scalar:
    """Return the contribution of a cross stream to the mean Nusselt number [-]."""
    damping = raise_constant(xp, 1.0 + raise_constant(xp, 0.4 / prandtl, 2.0 / 3.0), 0.25)
    laminar = 0.62 * xp.sqrt(reynolds) * raise_constant(xp, prandtl, 1.0 / 3.0) / damping
    turbulent = raise_constant(xp, 1.0 + raise_constant(xp, reynolds * (1.0 / 282000.0), 5.0 / 8.0), 0.8)
    return laminar * turbulent
