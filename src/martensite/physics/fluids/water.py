"""Liquid water near 0.1 MPa, after the IAPWS, 10 °C to 100 °C.

With T̃ = T/300 K, τ = T/10 K, a = 10 K/(593 K - T) and b = 10 K/(T - 232 K):

    μ = 1e-6 Pa s · Σ Aᵢ T̃^Bᵢ         k = Σ Cᵢ T̃^Dᵢ  [W/(m K)]
    v = R·10 K/p · (v₀ + Σ Eᵢ a^nᵢ + Σ Fᵢ b^mᵢ)
    c_p = -R · (c₃ + τ Σ nᵢ(nᵢ+1) Gᵢ a^(nᵢ+2) + τ Σ mᵢ(mᵢ+1) Hᵢ b^(mᵢ+2))

and ν = μ v, Pr = μ c_p/k, β = (∂v/∂T)/v. The formulation is valid from 253 K to 383 K. Properties are constant below 10
°C, because β vanishes at 4 °C and free-convection correlations fail there, and above 100 °C. Boiling is not modelled: a
surface above 100 °C loses more heat than computed.

Source: IAPWS SR6-08(2011); coefficients from the public code `iapws`.
"""

from martensite.base.interfaces import override
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.fluids.base import FLUIDS, AbstractFluid, FluidProperties

Terms = tuple[tuple[float, float], ...]
"""(factor, exponent) of each term of a sum of powers."""
Series = tuple[tuple[float, int], ...]
"""Terms of a series with integer exponents."""

GAS_CONSTANT = 461.51805
"""[J/(kg K)]"""
PRESSURE = 1e5
"""[Pa]"""
DYNAMIC: Terms = ((280.68, -1.9), (511.45, -7.7), (61.131, -19.6), (0.45903, -40.0))
CONDUCTIVITY: Terms = ((1.6630, -1.15), (-1.7781, -3.4), (1.1567, -6.0), (-0.432115, -7.6))
VOLUME_START = 1.93763157e-2
VOLUME_A: Series = ((6.74458446e3, 4), (-2.22521604e5, 5), (1.00231247e8, 7), (-1.63552118e9, 8), (8.32299658e9, 9))
VOLUME_B: Series = (
    (5.78545292e-3, 1),
    (-1.53195665e-2, 2),
    (3.11337859e-2, 3),
    (-4.23546241e-2, 4),
    (3.38713507e-2, 5),
    (-1.19946761e-2, 6),
)
HEAT_START = -8.983025854
HEAT_A: Series = ((-1.661470539e5, 4), (2.708781640e6, 5), (-1.557191544e8, 7))
HEAT_B: Series = ((-8.237426256e-1, 2), (1.908956353, 3), (-2.017597384, 4), (8.546361348e-1, 5))


@FLUIDS.register("water")
class Water(AbstractFluid):
    """Liquid water at 0.1 MPa, from 10 °C to 100 °C; no boiling."""

    cites = ("iapws-sr6-08", "iapws-code")

    @override
    def span(self) -> tuple[float, float]:
        return 283.15, 373.15

    @override
    def film_properties(self, xp: Namespace, temperature: Scalar) -> FluidProperties:
        log = xp.log(temperature * (1.0 / 300.0))
        dynamic = 1e-6 * _sum_powers(xp, DYNAMIC, log)
        conductivity = _sum_powers(xp, CONDUCTIVITY, log)
        a, b = 10.0 / (593.0 - temperature), 10.0 / (temperature - 232.0)
        volume, slope = _compute_volume(a, b)
        heat = _heat_capacity(temperature, a, b)
        return FluidProperties(
            conductivity=conductivity,
            viscosity=dynamic * volume,
            prandtl=dynamic * heat / conductivity,
            expansion=slope / volume,
        )


def _sum_powers(xp: Namespace, terms: Terms, log: Scalar) -> Scalar:
    """Return Σ factor · exp(exponent · log)."""
    total = 0.0
    for factor, exponent in terms:
        total = total + factor * xp.exp(exponent * log)
    return total


def _compute_volume(a: Scalar, b: Scalar) -> tuple[Scalar, Scalar]:
    """Return the specific volume [m³/kg] and its slope over temperature [m³/(kg K)]."""
    unit = GAS_CONSTANT / PRESSURE
    value = VOLUME_START + _sum_series(VOLUME_A, a, 0) + _sum_series(VOLUME_B, b, 0)
    slope = _sum_series(VOLUME_A, a, 1) - _sum_series(VOLUME_B, b, 1)
    return 10.0 * unit * value, unit * slope


def _heat_capacity(temperature: Scalar, a: Scalar, b: Scalar) -> Scalar:
    """Return the isobaric heat capacity [J/(kg K)]."""
    curvature = _sum_series(HEAT_A, a, 2) + _sum_series(HEAT_B, b, 2)
    return -GAS_CONSTANT * (HEAT_START + 0.1 * temperature * curvature)


def _sum_series(terms: Series, x: Scalar, order: int) -> Scalar:
    """Return the `order`-th derivative of Σ factor · xⁿ, with falling powers."""
    total = 0.0
    for factor, exponent in terms:
        for k in range(order):
            factor = factor * (exponent + k)
        product = factor * x
        for _ in range(exponent + order - 1):
            product = product * x
        total = total + product
    return total
