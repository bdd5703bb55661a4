"""Isobaric cycles whose transformation temperatures are known: straight lines, and laws."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from martensite.physics.laws.base import AbstractLaw
from martensite.signals.records import Record
from martensite.simulate.point import PathLeg, material_point

UNITS = {"time": "s", "temperature": "K", "strain": "1", "stress": "Pa"}


def record(temperature: Any, strain: Any, stress: Any, name: str = "cycle", interval: float | None = None) -> Record:
    """A record of one row per second."""
    count = len(temperature)
    held = np.broadcast_to(stress, count)
    columns = {
        "time": [float(k) for k in range(count)],
        "temperature": [float(t) for t in temperature],
        "strain": [float(e) for e in strain],
        "stress": [float(s) for s in held],
    }
    return Record(name, columns, UNITS, interval=interval)


@dataclass(frozen=True, kw_only=True)
class Bent:
    """A sample whose strain is straight from corner to corner, at all stresses."""

    A_s: float = 330.0
    A_f: float = 346.0
    M_s: float = 322.0
    M_f: float = 304.0
    C_A: float = 8e6
    C_M: float = 7e6
    H: float = 0.04
    alpha_A: float = 11e-6
    alpha_M: float = 5e-6
    residual: float = 0.0005

    def at(self, stress: float) -> dict[str, float]:
        """Temperatures at a stress."""
        up, down = stress / self.C_A, stress / self.C_M
        return {"A_s": self.A_s + up, "A_f": self.A_f + up, "M_s": self.M_s + down, "M_f": self.M_f + down}

    def cold(self, temperature: float, cooling: bool = False) -> float:
        """Strain of martensite."""
        return self.H + self.alpha_M * (temperature - 300.0) + self.residual * cooling

    def hot(self, temperature: float) -> float:
        """Strain of austenite."""
        return self.alpha_A * (temperature - 300.0)

    def corners(self, stress: float, cooling: bool) -> tuple[float, float]:
        """Temperatures of the corners on the cold and on the hot side."""
        at = self.at(stress)
        return (at["M_f"], at["M_s"]) if cooling else (at["A_s"], at["A_f"])

    def half(self, stress: float, cooling: bool) -> float:
        """Where the flank meets the middle of the outer lines."""
        low, high = self.corners(stress, cooling)

        def beyond(temperature: float) -> float:
            share = (temperature - low) / (high - low)
            flank = (1.0 - share) * self.cold(low, cooling) + share * self.hot(high)
            return flank - 0.5 * (self.cold(temperature, cooling) + self.hot(temperature))

        first, last = beyond(low), beyond(high)
        return low + (high - low) * first / (first - last)

    def gap(self, stress: float, cooling: bool) -> float:
        """Vertical distance of the outer lines there."""
        half = self.half(stress, cooling)
        return self.cold(half, cooling) - self.hot(half)

    def strain(self, temperatures: Any, stress: float, cooling: bool) -> np.ndarray:
        """Strain on a branch."""
        low, high = self.corners(stress, cooling)
        T = np.asarray(temperatures, np.float64)
        share = (T - low) / (high - low)
        flank = (1.0 - share) * self.cold(low, cooling) + share * self.hot(high)
        cold = np.asarray([self.cold(t, cooling) for t in T])
        hot = np.asarray([self.hot(t) for t in T])
        return np.where(share <= 0.0, cold, np.where(share >= 1.0, hot, flank))

    def cycle(
        self,
        stress: float,
        rows: int = 150,
        noise: float = 0.0,
        seed: int = 0,
        coldest: float = 270.0,
        hottest: float = 410.0,
        hot_first: bool = False,
    ) -> Record:
        """One cycle from cold to hot to cold, or the other way round; noise as a share of H."""
        up = np.linspace(coldest, hottest, rows)
        down = up[::-1]
        branches = [(up, False), (down, True)]
        ordered = branches[::-1] if hot_first else branches
        T = np.concatenate([t for t, _ in ordered])
        strain = np.concatenate([self.strain(t, stress, cooling) for t, cooling in ordered])
        strain = strain + np.random.default_rng(seed).normal(0.0, noise * self.H, T.size)
        return record(T, strain, stress)


def edited(base: Record, name: str, values: Any) -> Record:
    """A record with another column."""
    return replace(base, columns=base.columns | {name: [float(v) for v in values]})


def isobar(
    law: AbstractLaw, stress: float, coldest: float, hottest: float, rows: int = 600, noise: float = 0.0, seed: int = 0
) -> Record:
    """What a law does under a stress, from cold to hot to cold, after a first cooling."""
    ends = (hottest, coldest)
    legs = [PathLeg(temperature=coldest, steps=4 * rows)]
    legs += [PathLeg(temperature=t, steps=rows) for t in ends]
    run = material_point(law, legs, start=(stress, hottest), tolerance=None)
    first = run.ends[1]
    strain = np.asarray(run.strain[first:])
    strain = strain + np.random.default_rng(seed).normal(0.0, noise * np.ptp(strain), strain.size)
    return record(run.temperature[first:], strain.tolist(), stress, f"{stress / 1e6:g} MPa")


def chord(core: float) -> float:
    """Slope of the least-squares line through the middle `core` of a cosine flank, over that of
    its tangent: of sin θ over ±θ₀ with sin θ₀ = `core`."""
    theta = math.asin(core)
    return 3.0 * (math.sin(theta) - theta * math.cos(theta)) / theta**3
