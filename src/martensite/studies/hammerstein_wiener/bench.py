"""The bench of the study: a wire that lifts a weight, its driver and its two sensors.

The hysteresis is a Preisach model with measured branches (`preisach`), and the heat balance is solved by enthalpy, so
no model is tested on data of its own equations; only the lumped heat balance is common.

    C dT + ΔH dz = (I² R - h π d (T - T_a)) dt       per metre of wire
    h = 40 + 9 (T - T_a)^¼ W/(m² K),  R = R_0 (1 - 0.12 z),  I = √u U/(R + R_s)
    y' = (s z - y)/τ

Geometry, load, largest current and ambient are from the paper; heat capacity, latent heat and resistance are usual for
NiTi; the film coefficient gives cycle times like the paper's; lags and sensor noise are assumed. The wire carries 48
MPa, represented by the loop at 50 MPa; heavier loads shift it towards the loop at 100 MPa.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from martensite.base.parameters import Number, Parametrised, param, part
from martensite.control.sensors.base import Probe
from martensite.control.sensors.position import PositionSensor
from martensite.control.sensors.thermometer import InfraredSensor
from martensite.kernels import floats
from martensite.physics.electrical.switches import PwmVoltage
from martensite.studies.hammerstein_wiener import branches
from martensite.studies.hammerstein_wiener.preisach import Cell, everett_function

INTERVAL = 0.002
"""Sample time of the paper [s]."""
PIECES = 2
"""Steps of the heat balance per sample."""
GRAVITY = 9.81
METRE = 0.23
"""Length of the paper's wire [m]."""


class ReferenceBench(Parametrised):
    """Parts of the bench; the defaults are the reference bench."""

    cites = ("copaci2019", "leal2016")

    diameter: Number = param("m", "diameter of the wire", above=0.0, default=0.51e-3)
    length: Number = param("m", "length of the wire", above=0.0, default=METRE)
    density: Number = param("kg/m^3", "density", above=0.0, default=6450.0)
    specific_heat: Number = param("J/(kg K)", "specific heat capacity", above=0.0, default=837.0)
    latent_heat: Number = param("J/kg", "latent heat of transformation", above=0.0, default=24.2e3)
    conductivity: Number = param("W/(m K)", "thermal conductivity", low=0.0, default=18.0)
    load: Number = param("kg", "weight that it lifts", low=0.5, high=2.05, default=1.0)
    correlation: Number = param(
        "1", "correlation of the relays: shape of minor loops", low=0.0, high=0.99, default=0.85
    )
    resistance: Number = param("ohm/m", "resistance of martensite", above=0.0, default=4.3)
    resistance_drop: Number = param("1", "share lost to austenite", low=0.0, high=0.9, default=0.12)
    ambient: Number = param("K", "temperature of the surroundings", low=260.0, default=296.15)
    fan: Number = param("1", "factor on the film coefficient", above=0.0, default=1.0)
    lag: Number = param("s", "time constant of the weight", above=0.0, default=0.02)
    cells: Number = param(
        "1",
        "cells along half the wire, each twice as long as the one nearer to the crimp; 1 is a "
        "wire at one temperature that loses no heat to crimps",
        low=1.0,
        high=8.0,
        default=1.0,
    )
    driver: Any = part(
        "driver: duty cycle to current", default=PwmVoltage(supply=19.2 * METRE, series_resistance=0.5 * METRE)
    )
    thermometer: Any = part("sensor of the temperature", default=InfraredSensor())
    encoder: Any = part("sensor of the position", default=PositionSensor())

    @property
    def section(self) -> float:
        """Cross-section [m²]."""
        return 0.25 * math.pi * self.diameter**2

    @property
    def capacity(self) -> float:
        """Return C [J/(m K)]."""
        return self.section * self.density * self.specific_heat

    @property
    def latent(self) -> float:
        """Return ΔH [J/m]."""
        return self.section * self.density * self.latent_heat

    @property
    def share(self) -> float:
        """Return the relative position of the load between the loops at 50 and 100 MPa; 0 at 1 kg."""
        return (self.load - 1.0) * GRAVITY / self.section / 50e6

    @property
    def stroke(self) -> float:
        """Return the full stroke s [m]."""
        return self.length * branches.build_loop(self.share).stroke

    def film(self, above: float) -> float:
        """Return h [W/(m² K)] of a wire at `above` [K] over ambient."""
        return self.fan * (40.0 + 9.0 * math.sqrt(math.sqrt(above)) if above > 0.0 else 40.0)


class RunningBench:
    """A running bench with its true state and sensor readings."""

    def __init__(self, bench: ReferenceBench, seed: int = 0) -> None:
        """Start at ambient temperature.

        Args:
            bench: the parts.
            seed: seed of the sensor noise.
        """
        self.bench = bench
        count = int(bench.cells)
        weights = everett_function(bench.share, bench.correlation)
        self._wire = [Cell(weights, bench.capacity, bench.latent, bench.ambient) for _ in range(count)]
        sizes = [2.0**k for k in range(count)]
        self._shares = [size / sum(sizes) for size in sizes]
        self._lengths = [0.5 * bench.length * share for share in self._shares]
        self._stroke, self._rim = bench.stroke, math.pi * bench.diameter
        self.position = 0.0
        heat, place = np.random.default_rng(seed).spawn(2)
        self._thermometer = Probe(bench.thermometer, heat)
        self._encoder = Probe(bench.encoder, place)

    @property
    def temperature(self) -> float:
        """Return the temperature of the middle of the wire [K]."""
        return self._wire[-1].temperature

    @property
    def fraction(self) -> float:
        """Return the austenite fraction of the whole wire."""
        if len(self._wire) == 1:
            return self._wire[0].fraction
        return sum(s * c.fraction for s, c in zip(self._shares, self._wire, strict=True))

    def measured(self, dt: float = INTERVAL) -> tuple[float, float]:
        """Return the readings of temperature [K] and position [m], `dt` after the last ones."""
        state = (self.temperature, self.bench.ambient)
        return self._thermometer.read(state, dt), self._encoder.read((self.position,), dt)

    def step(self, duty: float, dt: float = INTERVAL) -> None:
        """Advance under a duty cycle (0 to 1)."""
        piece = dt / PIECES
        follow = 1.0 - math.exp(-piece / self.bench.lag)
        for _ in range(PIECES):
            for cell, power in zip(self._wire, self._powers(duty), strict=True):
                cell.heat(power * piece)
            self.position += follow * (self._stroke * self.fraction - self.position)

    def _powers(self, duty: float) -> list[float]:
        bench = self.bench
        ambient, drop = bench.ambient, bench.resistance_drop
        whole = bench.resistance * (1.0 - drop * self.fraction)
        current = bench.driver.current(floats, duty, bench.length * whole)
        squared = current * current * bench.resistance
        powers: list[float] = []
        for cell in self._wire:
            above = cell.temperature - ambient
            lost = self._rim * bench.film(above) * above
            powers.append(squared * (1.0 - drop * cell.fraction) - lost)
        if len(powers) > 1:
            self._conduct(powers)
        return powers

    def _conduct(self, powers: list[float]) -> None:
        conductance = self.bench.conductivity * self.bench.section
        before, size = self.bench.ambient, 0.0
        for k, (cell, length) in enumerate(zip(self._wire, self._lengths, strict=True)):
            flow = conductance * (before - cell.temperature) / (0.5 * (size + length))
            powers[k] += flow / length
            if k:
                powers[k - 1] -= flow / size
            before, size = cell.temperature, length
