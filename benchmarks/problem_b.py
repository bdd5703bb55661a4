"""Benchmark problem B: a Müller–Achenbach–Seelecke wire, heated by a power, on a bias spring.

What: one page with every number of the problem, and the system of the library that poses it.
Equations (x₊, x₋ fractions of the martensite variants, T [K], ⟨y⟩ = max(y, 0), λ = V/(k_B T)):

    state     dx₊/dt = A p_A₊ - x₊ p_₊A,  dx₋/dt = A p_A₋ - x₋ p_₋A,  A = 1 - x₊ - x₋
    heat      M c dT/dt = P - h S (T - T_a) + M latent (dx₊/dt + dx₋/dt)
    material  eps = eps_T (x₊ - x₋) + sigma D,  D = (x₊ + x₋)/E_M + A/E_A
    spring    sigma = sigma0 + K (eps0 - eps),  x = l (sigma - sigma0)/K
    rates     p_A₊ = exp(-λ⟨s_A - sigma⟩²/2E_A)/τ,  p_₊A = exp(-λ⟨sigma - s_M⟩²/2E_M)/τ, and with
              -sigma for x₋;  s_A = sigma_L + dsigma_dT (T - T_L),  s_M = s_A - Delta_sigma

Start: all martensite M+ at ambient temperature, the spring at its preload. The barriers make the
rates change by many decades within a step; `stiff` makes them thinner and faster still.
Source: equations of Seelecke and Müller (2004) with a rigid bridge between the wells; numbers
chosen for this project (they describe no tested wire). Sign: x > 0 when the hot wire shortens.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

DURATION = 20.0  # [s]
OUTPUT_INTERVAL = 0.1  # [s]
POWER = ((0.0, 1.0, 6.0, 8.0, 13.0, 20.0), (0.0, 0.0, 2.0, 2.0, 0.0, 0.0))  # [s], [W], linear

# time [s] -> (x [mm], T [K], x₊), computed for this project (Rodas4, rtol 1e-11).
REFERENCE = {
    5.0: (13.315107, 337.929068, 0.39514058),
    8.0: (22.515584, 365.241518, 0.0),
    11.0: (16.170898, 333.019674, 0.27057522),
    12.0: (8.319042, 320.331642, 0.61735599),
}
RANGE = 22.515584  # [mm]


class Wire(NamedTuple):
    """Parameters of problem B."""

    h: float = 200.0  # [W/m^2/K] heat loss
    sigma_L: float = 210e6  # [Pa] at T_L
    dsigma_dT: float = 4e6  # [Pa/K]
    Delta_sigma: float = 52e6  # [Pa]
    layer_volume: float = 5e-23  # [m^3]
    layer_time: float = 5e-3  # [s]
    eps_T: float = 0.05  # [1]
    latent: float = 25e3  # [J/kg]
    c: float = 500.0  # [J/kg/K]
    E_M: float = 28e9  # [Pa]
    E_A: float = 70e9  # [Pa]
    T_L: float = 320.0  # [K]
    T_a: float = 293.0  # [K]
    density: float = 6450.0  # [kg/m^3]
    diameter: float = 0.1e-3  # [m]
    length: float = 0.44  # [m]
    preload: float = 1.18  # [N]
    rate: float = 50.0  # [N/m]


MATERIAL = (*("E_A", "E_M", "eps_T", "sigma_L", "T_L", "dsigma_dT", "Delta_sigma"), *("layer_volume", "layer_time"))


class Lumped(NamedTuple):
    """Values that follow from a `Wire`."""

    M: float  # [kg]
    S: float  # [m^2]
    sigma0: float  # [Pa]
    K: float  # [Pa] spring rate seen as a modulus
    eps0: float  # [1]


def lumped(p: Wire) -> Lumped:
    """Mass, surface and spring of the wire."""
    area = math.pi * p.diameter**2 / 4
    sigma0 = p.preload / area
    return Lumped(
        M=p.density * area * p.length,
        S=math.pi * p.diameter * p.length,
        sigma0=sigma0,
        K=p.rate * p.length / area,
        eps0=p.eps_T + sigma0 / p.E_M,
    )


def stiff(p: Wire) -> Wire:
    """Layers ten times faster and four times larger."""
    return p._replace(layer_time=p.layer_time / 10, layer_volume=4 * p.layer_volume)


def system(p: Wire, law: str = "mas", **options: Any) -> Any:
    """The problem posed to the library; `options` are further numbers and options of the law.

    The form of the rates is `edge` unless they say otherwise.
    """
    from martensite.actuators.assembly import System
    from martensite.actuators.elements.wire import Wire as Element
    from martensite.actuators.mechanisms.load_line import BiasSpring
    from martensite.physics.electrical.resistances import PerLengthResistance
    from martensite.physics.electrical.sources import PowerSource
    from martensite.physics.laws.base import LAWS
    from martensite.physics.thermal.base import Environment
    from martensite.physics.thermal.films import ConstantCooling

    if law == "mas":
        options = {"rates": "edge"} | options
    numbers = {name: getattr(p, name) for name in MATERIAL}
    wire = Element(
        diameter=p.diameter,
        length=p.length,
        density=p.density,
        heat_capacity=p.c,
        latent_heat=p.latent,
        law=LAWS[law](**(numbers | options)),
        resistance=PerLengthResistance(r_A=126.0, r_M=126.0),  # any: the power is given
    )
    return System(
        element=wire,
        environment=Environment(temperature=p.T_a, cooling=ConstantCooling(h=p.h)),
        source=PowerSource(),
        mechanism=BiasSpring(stiffness=p.rate, preload=p.preload),
    )


def waveform() -> Any:
    """The power as a waveform of the library."""
    from martensite.signals.table import Table

    times, watts = POWER
    return Table(times=times, values=watts)
