"""A wire whose layers jump at rates, as three ordinary differential equations, by SciPy.

Shares no code with the package: the single crystal of Müller, Achenbach and Seelecke with the edges
of its wells for barriers, heated by P(t) = U(t)²/R, I² R or P, on a spring or a weight (k = 0).

    dx₊/dt = A p(σ_A - σ, E_A) - x₊ p(σ - σ_M, E_M),    p(d, E) = exp(-V ⟨d⟩²/(2 E k_B T))/τ
    C dT/dt = P - h S (T - T_a) + L dξ/dt,    σ = [s₀ + K (e₀ - ε_T (x₊ - x₋))]/(1 + K D)

and x₋ likewise with -σ. Radau goes from edge to edge of the drive.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from laboratory.scenarios import DRIVES, SOURCES, Scenario, make_wave
from martensite.actuators.assembly import System
from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.physics.electrical.resistances import PerLengthResistance
from martensite.physics.laws.mas import MullerAchenbachSeelecke
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling

BOLTZMANN = 1.380649e-23
RTOL, ATOL = 1e-9, (1e-11, 1e-11, 1e-8)
INSIDE = 1e-9
"""Share of a piece between two edges by which the drive is read inside of it."""


@dataclass
class Layers:
    """All numbers of a wire and its load line, in SI."""

    drive: str
    """`voltage`, `current` or `power`."""
    numbers: dict[str, float]
    signal: Callable[[float], float]
    edges: Sequence[float]

    def __getattr__(self, name: str) -> float:
        return self.__dict__["numbers"][name]

    def stress(self, plus: float, minus: float) -> float:
        D = (plus + minus) / self.E_M + (1.0 - plus - minus) / self.E_A
        return (self.s0 + self.K * (self.e0 - self.eps_T * (plus - minus))) / (1.0 + self.K * D)

    def jump(self, distance: float, modulus: float, T: float) -> float:
        d = max(distance, 0.0)
        return math.exp(-self.layer_volume * d * d / (2.0 * modulus * BOLTZMANN * T)) / self.layer_time

    def rates(self, u: float, y: Sequence[float]) -> list[float]:
        plus, minus, T = y
        s, T = self.stress(plus, minus), max(T, 100.0)
        A = 1.0 - plus - minus
        s_A = max(self.sigma_L + self.dsigma_dT * (T - self.T_L), 0.0)
        s_M = s_A - self.Delta_sigma
        up = A * self.jump(s_A - s, self.E_A, T) - plus * self.jump(s - s_M, self.E_M, T)
        down = A * self.jump(s_A + s, self.E_A, T) - minus * self.jump(-s - s_M, self.E_M, T)
        R = self.R_A + (plus + minus) * (self.R_M - self.R_A)
        power = {"voltage": u * u / R, "current": u * u * R, "power": max(u, 0.0)}[self.drive]
        return [up, down, (power - self.hS * (T - self.T_a) + self.latent * (up + down)) / self.C]

    def run(self, times: Sequence[float]) -> np.ndarray:
        """Rows of T, ξ, σ at ascending times from 0 on."""
        y, rows = [1.0, 0.0, self.T_a], [[1.0, 0.0, self.T_a]]
        for a, b in pairwise([0.0, *(e for e in self.edges if e < times[-1]), times[-1]]):
            hair = INSIDE * (b - a)

            def slopes(t: float, y: Sequence[float], a: float = a + hair, b: float = b - hair):
                return self.rates(self.signal(min(max(t, a), b)), y)

            found = solve_ivp(
                slopes, (a, b), y, "Radau", rtol=RTOL, atol=ATOL, dense_output=True, max_step=self.longest
            )
            while len(rows) < len(times) and times[len(rows)] <= b * (1.0 + 1e-12):
                rows.append(list(found.sol(min(times[len(rows)], b))))
            y = found.y[:, -1]
        return np.array([[T, p + m, self.stress(p, m)] for p, m, T in rows])


def make_layers(seed: int, drive: str | None = None) -> Scenario:
    """The scenario of a seed, with a drive of a kind."""
    rng = np.random.default_rng(seed)
    source = str(rng.choice(list(SOURCES)))
    drive = drive or str(rng.choice(DRIVES))
    ambient, h = rng.uniform(288.0, 303.0), rng.uniform(40.0, 200.0)
    d, length = rng.uniform(0.1e-3, 0.3e-3), rng.uniform(0.1, 0.4)
    section, surface = 0.25 * math.pi * d * d, math.pi * d * length
    stress, spring = rng.uniform(100e6, 200e6), rng.random() < 0.7
    slope, width, eps_T = rng.uniform(4e6, 8e6), rng.uniform(40e6, 120e6), rng.uniform(0.03, 0.05)
    law: dict[str, Any] = {
        "E_A": rng.uniform(50e9, 80e9),
        "E_M": rng.uniform(20e9, 40e9),
        "eps_T": eps_T,
        "sigma_L": stress + width + slope * rng.uniform(0.0, 15.0),
        "T_L": ambient + 20.0,
        "dsigma_dT": slope,
        "Delta_sigma": width,
        "layer_volume": 10.0 ** rng.uniform(-23.0, -22.0),
        "layer_time": 10.0 ** rng.uniform(-4.0, -2.0),
    }
    density, c, latent = 6450.0, rng.uniform(400.0, 837.0), rng.uniform(10e3, 25e3)
    r_A = 1.0 / (1.2e6 * section)
    r_M = r_A * rng.uniform(1.0, 1.2)
    stiffness = rng.uniform(0.0, 2.0) * stress * section / (0.04 * length) if spring else 0.0
    weight = stress * section
    system = System(
        element=Wire(
            diameter=d,
            length=length,
            density=density,
            heat_capacity=c,
            latent_heat=latent,
            law=MullerAchenbachSeelecke(**law, rates="edge"),
            resistance=PerLengthResistance(r_A=r_A, r_M=r_M),
        ),
        environment=Environment(temperature=ambient, cooling=ConstantCooling(h=h)),
        source=SOURCES[source](),
        mechanism=(BiasSpring(stiffness=stiffness, preload=weight) if spring else DeadWeight(mass=weight / 9.80665)),
    )
    mass, hS = density * section * length, h * surface
    constant = mass * c / hS
    hot = law["T_L"] + (stress + width - law["sigma_L"] + width) / slope + rng.uniform(10.0, 60.0)
    watts = hS * max(hot - ambient, 40.0)
    level = {"power": watts, "voltage": math.sqrt(watts * r_A * length), "current": math.sqrt(watts / (r_A * length))}[
        source
    ]
    waveform, duration = make_wave(rng, drive, level, constant, source)
    numbers = {
        **law,
        "s0": stress,
        "K": stiffness * length / section,
        "e0": eps_T + stress / law["E_M"],
        "hS": hS,
        "C": mass * c,
        "latent": mass * latent,
        "R_A": r_A * length,
        "R_M": r_M * length,
        "T_a": ambient,
        "longest": min([0.1 * constant, *(0.05 / tone.rate for tone in waveform.tones())]),
    }
    equations = Layers(source, numbers, waveform.value, waveform.edges(duration))
    return Scenario(f"layers, {source}, {drive}", system, waveform, duration, equations)
