"""One-page stress–strain relation of Elahinia and Ashrafiuon; shares no code with the package.

    integrated   ε = [σ - Θ (T - T_ref)]/E + ε_L ξ,          E = E_A + ξ (E_M - E_A)
    rate form    dσ = E dε - ε_L E dξ + (E_M - E_A)(ε - ε_L ξ) dξ + Θ dT

The kinetics are those of Liang and Rogers (`liang_rogers_reference`). The rate form is integrated
by the midpoint rule along rows of (ξ, σ, T); as printed, it lacks the third term.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np


@dataclass(frozen=True)
class Solid:
    E_A: float  # [Pa]
    E_M: float
    eps_L: float
    Theta: float  # [Pa/K]
    T_ref: float  # [K]

    def strain(self, xi, sigma, T):
        """Integrated form [-]."""
        return (sigma - self.Theta * (T - self.T_ref)) / self.modulus(xi) + self.eps_L * xi

    def modulus(self, xi):
        return self.E_A + xi * (self.E_M - self.E_A)

    def strains(self, rows, start, printed=False):
        """Strain after every row by the rate form, from the strain `start` at the first row."""
        found = [start]
        for (xi0, s0, T0), (xi1, s1, T1) in pairwise(rows):
            change = xi1 - xi0, s1 - s0, T1 - T0
            half = self.change(found[-1], xi0, *change, printed)
            middle = found[-1] + 0.5 * half, 0.5 * (xi0 + xi1)
            found.append(found[-1] + self.change(*middle, *change, printed))
        return np.array(found)

    def change(self, strain, xi, dxi, dsigma, dT, printed):
        """dε of the rate form."""
        E = self.modulus(xi)
        third = 0.0 if printed else (self.E_M - self.E_A) * (strain - self.eps_L * xi) * dxi
        return (dsigma - self.Theta * dT - third) / E + self.eps_L * dxi
