"""A coil spring whose section is integrated, by SciPy alone: no code of the package.

Brinson's law at constant temperature, loaded from zero: the strain of a fibre is inverted by `brentq`, the torque is
an integral over the radius by `quad`, cut where fibres begin and end to transform.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from scipy.integrate import quad
from scipy.optimize import brentq


@dataclass(frozen=True)
class BrinsonFibre:
    """Numbers of the law, and whether martensite is there from the beginning, all of it twinned."""

    E_A: float
    E_M: float
    eps_L: float
    C_M: float
    M_s: float
    sigma_s: float
    sigma_f: float
    temperature: float
    cold: bool

    @property
    def limits(self) -> tuple[float, float]:
        """Stresses between which detwinned martensite forms [Pa]."""
        more = self.C_M * max(self.temperature - self.M_s, 0.0)
        return self.sigma_s + more, self.sigma_f + more

    def strain(self, stress: float) -> float:
        """Strain under a stress that has risen from zero."""
        low, high = self.limits
        share = min(max((stress - low) / (high - low), 0.0), 1.0)
        oriented = 0.5 * (1.0 - math.cos(math.pi * share))
        fraction = 1.0 if self.cold else oriented
        return stress / (self.E_A + fraction * (self.E_M - self.E_A)) + self.eps_L * oriented

    def stress(self, strain: float) -> float:
        """Stress at a strain [Pa]."""
        found: Any = brentq(lambda s: self.strain(s) - strain, 0.0, self.E_A * strain + 1.0, xtol=1e-3, rtol=1e-14)
        return found


def find_coil_force(fibre: BrinsonFibre, wire: float, coil: float, turns: float, elongation: float) -> float:
    """Force of a coil [N]: F D/2 = ∫ τ r dA with τ = σ/√3, γ = √3 ε = 2 r y/(π N D²)."""
    per_radius = 2.0 * elongation / (math.pi * turns * coil**2) / math.sqrt(3.0)
    bends = [fibre.strain(s) / per_radius for s in fibre.limits]
    ends = [0.0, *(b for b in bends if b < wire / 2), wire / 2]

    def torque(radius: float) -> float:
        return fibre.stress(per_radius * radius) / math.sqrt(3.0) * 2.0 * math.pi * radius**2

    pieces = (quad(torque, a, b, epsabs=0.0, epsrel=1e-9)[0] for a, b in pairwise(ends))
    return sum(pieces) * 2.0 / coil
