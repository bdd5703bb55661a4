"""Rigs of rate-independent tests drawn at random: bath, angle, constrained recovery, tensile tests and DSC.

The wire follows the cosine law of Liang and Rogers. Its equilibrium with the load is solved here by bisection, without
code of the package.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from martensite.signals.records import Record

ZERO = 273.15
UNITS = {"time": "s", "temperature": "K", "strain": "1", "stress": "Pa", "position": "m", "force": "N"}


@dataclass(frozen=True)
class CosineWire:
    """Wire with cosine kinetics; temperatures in degC, stresses in Pa."""

    A_s: float
    A_f: float
    M_s: float
    M_f: float
    C: float
    E_A: float
    E_M: float
    eps: float

    def strain(self, stress: float, xi: float) -> float:
        """Return the strain at a stress [Pa] and a martensite fraction."""
        return stress / (self.E_A + xi * (self.E_M - self.E_A)) + self.eps * xi

    def fraction(self, celsius: float, stress: float, begin: float, reverse: bool) -> float:
        """Return the martensite fraction on a branch that began with a fraction."""
        if reverse:
            share = (celsius - self.A_s - stress / self.C) / (self.A_f - self.A_s)
            return begin * 0.5 * (1.0 + math.cos(math.pi * min(max(share, 0.0), 1.0)))
        share = (self.M_s + stress / self.C - celsius) / (self.M_s - self.M_f)
        return begin + (1.0 - begin) * 0.5 * (1.0 - math.cos(math.pi * min(max(share, 0.0), 1.0)))


@dataclass(frozen=True)
class GivenRig:
    """Records of a test, one more for the prediction, and the truth."""

    kind: str
    records: tuple[Record, ...]
    unseen: Record
    column: str
    """Measured column of the unseen record."""
    settings: Mapping[str, Any]
    """Known values by dotted path."""
    wire: CosineWire


def draw_wire(chance: np.random.Generator) -> CosineWire:
    """Return a wire that is martensite at room temperature."""
    top, wide, apart = chance.uniform(62, 92), chance.uniform(8, 20), chance.uniform(8, 20)
    moduli = chance.uniform(50e9, 80e9), chance.uniform(20e9, 35e9)
    places = top - wide, top, top - apart, top - apart - chance.uniform(8, 20)
    return CosineWire(*places, chance.uniform(6e6, 9e6), *moduli, chance.uniform(0.03, 0.05))


def solve_load(wire: CosineWire, celsius: Sequence[float], line: tuple[float, float, float]) -> tuple[Any, Any]:
    """Return stress [Pa] and strain over a path of temperatures [degC], from martensite.

    Args:
        wire: the wire.
        celsius: temperatures of the rows.
        line: stress of the load at the first row [Pa], its rise per shortening strain [Pa], and 1 to hold the length
            instead.
    """
    preload, rise, held = line
    begin = wire.strain(preload, 1.0)
    start, xi, found = 1.0, 1.0, list[tuple[float, float]]()
    reverse = True
    for before, now in zip([celsius[0], *celsius], celsius, strict=False):
        if now != before and (now > before) != reverse:
            reverse, start = now > before, xi
        low, high = 0.0, 4e9
        for _ in range(50):
            stress = 0.5 * (low + high)
            xi = wire.fraction(now, stress, start, reverse)
            strain = wire.strain(stress, xi)
            over = strain > begin if held else stress > preload + rise * (begin - strain)
            low, high = (low, stress) if over else (stress, high)
        found.append((stress, strain))
    return tuple(np.array(one) for one in zip(*found, strict=True))  # type: ignore[return-value]


def solve_tension(wire: CosineWire, celsius: float, tops: Sequence[float]) -> tuple[Any, Any]:
    """Return stress [Pa] and strain of loops to some strains at one temperature [degC], from austenite."""
    stresses, strains = list[float](), list[float]()
    start = 0.0
    for top in tops:
        for reverse in (False, True):
            rows, last = np.arange(0.0, 1.5e9, 4e6), start
            branch = list[tuple[float, float, float]]()
            for stress in rows if not reverse else rows[rows <= stresses[-1]][::-1]:
                xi = wire.fraction(celsius, stress, start, reverse)
                xi = max(xi, last) if not reverse else min(xi, last)
                branch.append((stress, wire.strain(stress, xi), xi))
                last = xi
                if not reverse and branch[-1][1] > top:
                    break
            stresses += [one[0] for one in branch]
            strains += [one[1] for one in branch]
            start = branch[-1][2]
    return np.array(stresses), np.array(strains)


def make_path(low: float, turns: Sequence[float], rows: int) -> list[float]:
    """Return temperatures that rise from `low` and turn at each of some temperatures."""
    ends = [low, *turns]
    legs = [np.linspace(a, b, rows, endpoint=False) for a, b in pairwise(ends)]
    return [float(x) for leg in legs for x in leg]


def make_record(
    name: str, columns: Mapping[str, Any], chance: np.random.Generator, noise: Mapping[str, float]
) -> Record:
    """Return a record with white noise, as fractions of the range of a column or, for temperatures, in kelvin."""
    rows = len(next(iter(columns.values())))
    whole: dict[str, Any] = {"time": np.arange(float(rows))}
    for key, column in columns.items():
        size = noise.get(key, 0.0) * (1.0 if key == "temperature" else float(np.ptp(column)))
        whole[key] = np.asarray(column) + size * chance.standard_normal(rows)
    return Record(name, {n: x.tolist() for n, x in whole.items()}, {n: UNITS[n] for n in whole}, interval=1.0)


def draw_given_rig(kind: str, seed: int) -> GivenRig:
    """Return a rig of a kind: `bath`, `recovery` or `tensile`."""
    chance = np.random.default_rng(seed)
    wire = draw_wire(chance)
    width, length = float(chance.choice([0.25e-3, 0.5e-3, 1e-3])), float(chance.uniform(0.05, 0.3))
    sizes = {"element.diameter": f"{width} m", "element.length": f"{length} m"}
    area = math.pi / 4.0 * width**2
    if kind == "tensile":
        return _draw_tensile(wire, chance, sizes)
    held = kind == "recovery"
    preload = chance.uniform(10e6, 30e6) if held else chance.uniform(60e6, 180e6)
    rise = 0.0 if held or chance.random() < 0.5 else chance.uniform(0.2, 0.8) * preload / wire.eps
    hot = wire.A_f + (preload + 40e6 + rise * wire.eps) / wire.C + 15.0
    low = wire.M_f - 15.0
    logs = list[Record]()
    for name, turns in (("log", (hot, low)), ("unseen", (0.5 * (wire.A_s + wire.A_f) + preload / wire.C, low))):
        celsius = make_path(low, turns, 180)
        stress, strain = solve_load(wire, celsius, (preload, rise, float(held)))
        columns: dict[str, Any] = {"temperature": np.array(celsius) + ZERO}
        if held:
            columns["stress"] = stress
        else:
            columns["position"] = length * (strain[0] - strain)
            columns |= {"force": stress * area} if rise else {}
        noise = {"temperature": 0.1, "position": 0.003, "stress": 0.003, "force": 0.001}
        logs.append(make_record(name, columns, chance, noise))
    given = {"element.law.E_A": f"{wire.E_A} Pa", "element.law.E_M": f"{wire.E_M} Pa"}
    given |= {"element.law.eps_L": f"{wire.eps}"} if held else {}
    given |= {"element.law.C_A": f"{wire.C} Pa/K", "element.law.C_M": f"{wire.C} Pa/K"} if not held else {}
    given |= {} if rise or held else {"mechanism.mass": f"{preload * area / 9.80665} kg"}
    column = "stress" if held else "position"
    return GivenRig(kind, (logs[0],), logs[1], column, sizes | given, wire)


def _draw_tensile(wire: CosineWire, chance: np.random.Generator, sizes: Mapping[str, Any]) -> GivenRig:
    """Return superelastic loops at three temperatures, and partial loops at a fourth."""
    logs = list[Record]()
    for name, above in (("cool", 8.0), ("middle", 22.0), ("hot", 36.0), ("unseen", 30.0)):
        celsius = wire.A_f + above
        tops = (1.15 * wire.eps + 0.012,) if name != "unseen" else (0.5 * wire.eps, 0.9 * wire.eps)
        stress, strain = solve_tension(wire, celsius, tops)
        columns = {"strain": strain, "stress": stress, "temperature": np.full(len(strain), celsius + ZERO)}
        logs.append(make_record(name, columns, chance, {"stress": 0.003, "temperature": 0.0}))
    return GivenRig("tensile", tuple(logs[:3]), logs[3], "stress", sizes, wire)
