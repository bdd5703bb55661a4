"""A finger of two elastic-driven joints against a cylinder and stops: all sets of contacts, one after another.

It shares no code with the package. For every set of constraints that might touch, SciPy finds the root of balance and
closed gaps; the answer is the one whose other gaps are open and whose reactions push. Geometry in complex numbers: a
finger lies along 1 and bends towards i.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy import optimize


@dataclass(frozen=True)
class GrippingFinger:
    """Numbers of a finger, in SI."""

    offset: float
    bracket: float
    knuckle: float
    compliance: float
    preload: float
    drawn: tuple[float, float, float, float]
    """Free shortening of proximal flexor and extensor, then of the distal ones [m]."""
    passing: bool = False
    stiffness: float = 0.02
    torque: float = 1e-3
    lengths: tuple[float, float] = (0.05, 0.04)
    weights: tuple[float, float] = (0.0, 0.0)
    """[N]"""
    centres: tuple[float, float] = (0.5, 0.5)
    gravity: complex = 1.0
    """Direction."""
    range: tuple[float, float] = (0.0, 1.2)
    centre: complex = 0.04 + 0.04j
    reach: float = 0.025
    """Radius of the cylinder and half the thickness of a phalanx."""

    def lines(self, q: np.ndarray) -> list[tuple[complex, complex]]:
        """Both ends of both phalanges."""
        middle = self.lengths[0] * np.exp(1j * q[0])
        return [(0j, middle), (middle, middle + self.lengths[1] * np.exp(1j * (q[0] + q[1])))]

    def gaps(self, q: np.ndarray) -> np.ndarray:
        """Lower and upper stops, and the cylinder, of both joints."""
        apart = []
        for start, end in self.lines(q):
            unit = (end - start) / abs(end - start)
            seen = (self.centre - start) / unit
            apart.append(abs(seen - min(max(seen.real, 0.0), abs(end - start))) - self.reach)
        return np.array([*(q - self.range[0]), *(self.range[1] - q), *apart])

    def energy_less_tendons(self, q: np.ndarray) -> float:
        """Of joint springs and weight [J]."""
        held = float(np.sum(self.torque * q + 0.5 * self.stiffness * q**2))
        for (start, end), weight, share in zip(self.lines(q), self.weights, self.centres, strict=True):
            held -= weight * ((start + share * (end - start)) / self.gravity).real
        return held

    def paths(self, q: np.ndarray) -> np.ndarray:
        """Shortening of the four paths [m]: the holes of a flexor are at bracket ∓ i offset from its hinge."""
        hole = complex(self.bracket, self.offset)
        bow = [2.0 * self.bracket - abs(hole * np.exp(1j * one) + hole.conjugate()) for one in q]
        return np.array([bow[0], -self.knuckle * q[0], bow[1] + self.passing * bow[0], -self.knuckle * q[1]])

    @cached_property
    def start_forces(self) -> np.ndarray:
        """Tensions that hold springs and weight as assembled [N]."""
        home, rest = np.zeros(2), []
        lever, held = slope(self.paths, home), slope(lambda at: [self.energy_less_tendons(at)], home)[0]
        for k in (0, 1):
            bent = self.preload * (lever[0, k] + lever[2, k])
            rest += [self.preload, (bent - held[k]) / self.knuckle]
        return np.array(rest)

    def left_over(self, q: np.ndarray) -> np.ndarray:
        """Torque that tendons leave for the constraints [N m]."""
        held = slope(lambda at: [self.energy_less_tendons(at)], q)[0]
        forces = np.maximum(self.start_forces + (np.array(self.drawn) - self.paths(q)) / self.compliance, 0.0)
        return slope(self.paths, q).T @ forces - held

    def solve(self) -> tuple[np.ndarray, np.ndarray]:
        """Angles and reactions of the one set of constraints that is consistent."""
        found = []
        sets = itertools.chain.from_iterable(itertools.combinations(range(6), n) for n in range(3))
        for chosen in map(list, sets):

            def missing(x: np.ndarray, chosen: list[int] = chosen) -> np.ndarray:
                q, pushed = x[:2], x[2:]
                over = self.left_over(q) + slope(self.gaps, q)[chosen].T @ pushed
                return np.concatenate([over, 1e2 * self.gaps(q)[chosen]])

            root = optimize.root(missing, [0.3, 0.5, *np.zeros(len(chosen))], tol=1e-13, options={"maxfev": 60})
            q, pushed = root.x[:2], root.x[2:]
            if root.fun @ root.fun < 1e-18 and self.gaps(q).min() > -1e-9 and pushed.min(initial=0.0) >= 0.0:
                found.append((q, np.bincount(chosen, pushed, 6) if chosen else np.zeros(6)))
        if not found or any(np.abs(q - found[0][0]).max() > 1e-6 for q, _ in found):
            raise ValueError(f"{len(found)} sets of contacts are consistent: {found}")
        return found[0]


def slope(function: Any, at: np.ndarray) -> np.ndarray:
    """Jacobian by differences of fourth order."""
    columns = []
    for k in range(len(at)):
        h = np.zeros(len(at))
        h[k] = 1e-3
        values = [np.asarray(function(at + n * h)) for n in (-2, -1, 1, 2)]
        columns.append((values[0] - 8.0 * values[1] + 8.0 * values[2] - values[3]) / 12e-3)
    return np.array(columns).T
