"""Film coefficients that depend on temperatures only: constant, polynomial, radiation, and sums."""

from martensite.base.interfaces import override
from martensite.base.parameters import Number, param, part
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.thermal.base import COOLING, AbstractCooling, Cylinder


@COOLING.register("constant")
class ConstantCooling(AbstractCooling):
    """Constant film coefficient: Q = h S (T - T_a)."""

    h: Number = param("W/m^2/K", "film coefficient", low=0.0, high=1e5, typical="100 W/m^2/K")

    @override
    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        return self.h


@COOLING.register("polynomial")
class PolynomialCooling(AbstractCooling):
    """Film coefficient of second degree in temperature, h = h₀ + h₁ θ + h₂ θ².

    θ = T - `reference`. The default reference of 0 °C gives degrees Celsius, the form fitted to step responses in the
    MigaOne paper; a reference at the ambient temperature gives the overtemperature.
    """

    cites = ("migaone-paper",)

    h0: Number = param("W/m^2/K", "film coefficient at the reference", low=0.0, high=1e5, typical="60 W/m^2/K")
    h1: Number = param("W/m^2/K^2", "linear coefficient", low=-1e3, high=1e3, default=0.0, typical="0.1 W/m^2/K^2")
    h2: Number = param(
        "W/m^2/K^3", "quadratic coefficient", low=-10.0, high=10.0, default=0.0, typical="1e-4 W/m^2/K^3"
    )
    reference: Number = param("K", "temperature at which θ is zero", low=0.0, high=1000.0, default=273.15)

    @override
    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        theta = temperature - self.reference
        return xp.maximum(self.h0 + theta * (self.h1 + theta * self.h2), 0.0)


STEFAN_BOLTZMANN = 5.670374419e-8
"""σ_SB [W/(m² K⁴)]"""


@COOLING.register("radiation")
class Radiation(AbstractCooling):
    """Radiation of a grey wire to its surroundings.

        h = ε σ_SB (T² + T_a²)(T + T_a)          so that   h (T - T_a) = ε σ_SB (T⁴ - T_a⁴)

    for a grey surface that is small compared with its enclosure. h → 4 ε σ_SB T³ as T_a → T, about 6 W/(m² K) for a
    black wire at room temperature: little compared with convection from a thin wire. Add both with `combined`.
    """

    emissivity: Number = param("1", "emissivity of the surface", low=0.0, high=1.0, typical=0.6)

    @override
    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        squares = temperature * temperature + ambient * ambient
        return self.emissivity * STEFAN_BOLTZMANN * squares * (temperature + ambient)


@COOLING.register("combined")
class CombinedCooling(AbstractCooling):
    """Sum of two heat-loss models, h = h₁ + h₂, at the same ambient temperature.

    Any two models are allowed, also another `combined`.
    """

    convection: AbstractCooling = part("one heat-loss model", COOLING, typical="churchill-chu")
    radiation: AbstractCooling = part("the other heat-loss model", COOLING, typical="radiation")

    @override
    def film(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar:
        at = temperature, ambient, shape
        return self.convection.film(xp, *at) + self.radiation.film(xp, *at)

    @override
    def pump_heat(self, xp: Namespace, temperature: Scalar, ambient: Scalar, shape: Cylinder) -> Scalar | None:
        first, other = (one.pump_heat(xp, temperature, ambient, shape) for one in (self.convection, self.radiation))
        return other if first is None else first if other is None else first + other
