"""Random wires, drives and load lines, posed to the package and to the reference."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from laboratory.reference import Wire as Equations
from martensite.actuators.assembly import System
from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanisms.load_line import BiasSpring, DeadWeight
from martensite.physics.electrical.resistances import PerLengthResistance
from martensite.physics.electrical.sources import CurrentSource, PowerSource, VoltageSource
from martensite.physics.laws.strip_laws import LiangRogers, Tanaka
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.signals.base import AbstractWaveform
from martensite.signals.pwm import PulseWidthModulation
from martensite.signals.sine import Sine
from martensite.signals.step import Step
from martensite.signals.table import Table

SOURCES = {"voltage": VoltageSource, "current": CurrentSource, "power": PowerSource}
DRIVES = ("step", "sine", "round sine", "table", "pulses", "pwm", "fast pwm")
MOST_EDGES = 300
SAMPLES = 101


@dataclass(frozen=True)
class Scenario:
    """One case of the laboratory."""

    name: str
    """Kinetics, source and drive."""
    system: System
    waveform: AbstractWaveform
    duration: float
    """[s]"""
    equations: Any

    @property
    def times(self) -> list[float]:
        """Samples [s]."""
        return [self.duration * k / (SAMPLES - 1) for k in range(SAMPLES)]


def make_scenario(seed: int, drive: str | None = None) -> Scenario:
    """The scenario of a seed, with a drive of a kind."""
    rng = np.random.default_rng(seed)
    kind = str(rng.choice(["cosine", "exponential"]))
    source = str(rng.choice(list(SOURCES)))
    drive = drive or str(rng.choice(DRIVES))
    ambient, h = rng.uniform(288.0, 303.0), rng.uniform(40.0, 150.0)
    d, length = rng.uniform(0.1e-3, 0.4e-3), rng.uniform(0.1, 0.3)
    section, surface = 0.25 * math.pi * d * d, math.pi * d * length
    A_s = ambient + rng.uniform(25.0, 50.0)
    M_s = A_s - rng.uniform(5.0, 15.0)
    C_A = rng.uniform(6e6, 12e6)  # not above C_M: where strips overlap a rule decides, not physics
    law: dict[str, Any] = {
        "E_A": rng.uniform(50e9, 80e9),
        "E_M": rng.uniform(20e9, 40e9),
        "eps_L": rng.uniform(0.03, 0.05),
        "Theta": rng.uniform(0.0, 0.5e6),
        "T_ref": ambient,
        "A_s": A_s,
        "A_f": A_s + rng.uniform(5.0, 15.0),
        "M_s": M_s,
        "M_f": M_s - rng.uniform(5.0, 15.0),
        "C_A": C_A,
        "C_M": rng.uniform(C_A, 12e6),
    }
    if kind == "exponential":
        law["E_M"] = law["E_A"]
    density, c, latent = 6450.0, rng.uniform(400.0, 837.0), rng.uniform(10e3, 24e3)
    r_A = 1.0 / (1.2e6 * section)
    r_M = r_A * rng.uniform(1.0, 1.2)
    stress = rng.uniform(50e6, 150e6)
    spring = rng.random() < 0.7
    stiffness = rng.uniform(0.0, 2.0) * stress * section / (0.04 * length) if spring else 0.0
    mechanism = (
        BiasSpring(stiffness=stiffness, preload=stress * section)
        if spring
        else DeadWeight(mass=stress * section / 9.80665)
    )
    parts = LiangRogers(**law, modulus="mixture") if kind == "cosine" else Tanaka(**law)
    resistance = PerLengthResistance(r_A=r_A, r_M=r_M)
    system = System(
        element=Wire(
            diameter=d,
            length=length,
            density=density,
            heat_capacity=c,
            latent_heat=latent,
            law=parts,
            resistance=resistance,
        ),
        environment=Environment(temperature=ambient, cooling=ConstantCooling(h=h)),
        source=SOURCES[source](),
        mechanism=mechanism,
    )
    mass, hS = density * section * length, h * surface
    constant = mass * c / hS
    hot = law["A_f"] + stress * (1.0 + stiffness) ** 0 / law["C_A"] + rng.uniform(10.0, 60.0)
    watts = hS * (hot - ambient)
    level = {"power": watts, "voltage": math.sqrt(watts * r_A * length), "current": math.sqrt(watts / (r_A * length))}[
        source
    ]
    waveform, duration = make_wave(rng, drive, level, constant, source)
    E = law["E_M"]
    numbers = {
        **law,
        "s0": stress,
        "K": stiffness * length / section,
        "e0": law["eps_L"] + stress / E,
        "hS": hS,
        "C": mass * c,
        "latent": mass * latent,
        "R_A": r_A * length,
        "R_M": r_M * length,
        "T_a": ambient,
        "lowest": 1.0,
        "longest": min([0.05 * constant, *(0.05 / tone.rate for tone in waveform.tones())]),
    }
    equations = Equations(kind, source, numbers, waveform.value, waveform.edges(duration))
    return Scenario(f"{kind}, {source}, {drive}", system, waveform, duration, equations)


def make_wave(rng: Any, drive: str, level: float, constant: float, source: str) -> tuple[AbstractWaveform, float]:
    """A drive that now and then reaches a level, and how long it goes on [s]."""
    span = constant * rng.uniform(3.0, 8.0)
    if drive == "step":
        return Step(high=level, at=0.05 * span, until=0.6 * span), span
    if drive == "sine":
        return Sine(high=1.3 * level, frequency=rng.uniform(0.5, 4.0) / span), span
    if drive == "round sine":
        frequency = float(rng.choice([0.1, 0.2, 0.5, 1.0, 5.0]))
        span = min(float(rng.choice([10.0, 20.0, 60.0])), 50.0 / frequency)
        return Sine(high=1.3 * level, frequency=frequency), span
    if drive == "table":
        times = np.sort(rng.uniform(0.0, span, 6))
        times = (0.0, *(times + np.arange(6) * 1e-3 * span).tolist(), 1.1 * span)
        return Table(times=times, values=tuple((1.2 * level * rng.random(8)).tolist())), span
    if drive == "pulses":
        width = 10.0 ** rng.uniform(-3.0, 1.0)
        period = max(width * rng.uniform(2.0, 5.0), rng.uniform(0.5, 3.0) * constant)
        power = min(max(3.0, constant / width), 100.0)
        high = level * (power if source == "power" else math.sqrt(power))
        wave = PulseWidthModulation(high=high, frequency=1.0 / period, duty=width / period)
        return wave, period * int(rng.integers(2, 6))
    duty = rng.uniform(0.1, 0.9)
    high = level / (duty if source == "power" else math.sqrt(duty))
    frequency = 10.0 ** (rng.uniform(1.0, 2.0) if drive == "pwm" else rng.uniform(2.0, 4.0))
    wave = PulseWidthModulation(high=high, frequency=frequency, duty=duty)
    return wave, min(span, 0.5 * MOST_EDGES / frequency)


JUDGED = ("temperature", "martensite_fraction", "stress")
LEAST = (1.0, 0.01, 1e6)


def true_error(found: Sequence[Any], meant: Any) -> float:
    """Largest difference of temperature, fraction and stress, as a share of their ranges."""
    table = np.array(found).T
    ranges = np.maximum(np.ptp(meant, axis=0), LEAST)
    return float((np.abs(table - meant).max(axis=0) / ranges).max())
