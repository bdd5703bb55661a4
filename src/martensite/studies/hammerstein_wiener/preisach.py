"""Hysteresis of a wire as a Preisach model in Everett form, heated by energy.

    heating from the last minimum     z = z_m + E(T, T_m)
    cooling from the last maximum     z = z_M - E(T_M, T)

E(a, b) is the weight of the relays that switch up at or below a and down at or above b. Turning
points are kept on a stack; beyond the one before, an inner loop is closed and forgotten. Branches
give E only where one temperature is the end of the major loop; in between it is that of relays
whose thresholds are drawn with a Gaussian copula of some correlation, which thus shapes minor
loops and nothing else.

A wire with latent heat is stepped by its enthalpy H(T) = C T + ΔH z(T), which rises along every
branch: heat added gives the new H, and T follows without iteration, whatever the step.

This is none of the library's laws, and no model of this library is made of it.
"""

from __future__ import annotations

from bisect import bisect_right
from functools import lru_cache

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.special import ndtr

from martensite.control.sensors.base import Numbers
from martensite.studies.hammerstein_wiener import branches
from martensite.studies.hammerstein_wiener.branches import GRID

RELAYS = 200_000
SEED = 0
APART = 1.0
"""Least distance of the thresholds of a relay [K]."""
SMOOTHING = 5.0
"""Standard deviation of what smooths the relays, in steps of the grid."""
BEYOND = 2000.0
"""Distance outside the grid beyond which transformation ends [K]."""


@lru_cache(4)
def everett_function(share: float, correlation: float) -> Numbers:
    """E(a, b) on `GRID`, rows a, columns b, for branches between 50 and 100 MPa."""
    found = branches.build_loop(share)
    rng = np.random.default_rng(SEED)
    first = rng.standard_normal(RELAYS)
    second = correlation * first + np.sqrt(1.0 - correlation**2) * rng.standard_normal(RELAYS)
    up = branches.invert_branch(found.heating, ndtr(first))
    down = np.minimum(branches.invert_branch(found.cooling, ndtr(second)), up - APART)
    weights = gaussian_filter(np.histogram2d(up, down, bins=(GRID, GRID))[0], SMOOTHING)
    # what was smoothed across the diagonal is mirrored back, so that E is 0 there
    weights = np.tril(weights, -1) + np.triu(weights, 1).T
    count = len(GRID)
    made = np.zeros((count, count))
    made[1:, :-1] = (weights / weights.sum()).cumsum(axis=0)[:, ::-1].cumsum(axis=1)[:, ::-1]
    return made


class Cell:
    """A piece of wire at one temperature: temperature, fraction, and the turning points."""

    def __init__(self, weights: Numbers, capacity: float, latent: float, temperature: float) -> None:
        """Start on the heating branch from far below.

        Args:
            weights: E on the grid.
            capacity: C, per metre or of the whole piece [J/K].
            latent: ΔH, of as much [J].
            temperature: where it starts [K].
        """
        self._weights, self._C, self._L = weights, capacity, latent
        self.turns: list[tuple[float, float]] = [(float(GRID[0]), 0.0)]
        self.heating = True
        self._branch()
        at = bisect_right(self._T, temperature) - 1
        part = (temperature - self._T[at]) / (self._T[at + 1] - self._T[at])
        h = self._H[at] + part * (self._H[at + 1] - self._H[at])
        self.temperature, self.fraction = temperature, (h - capacity * temperature) / latent
        self.enthalpy = h

    def heat(self, energy: float) -> None:
        """Add heat, or take it away if it is negative, in the unit of the latent heat."""
        if energy == 0.0:
            return
        if (energy > 0.0) != self.heating:
            self.turns.append((self.temperature, self.fraction))
            self.heating = energy > 0.0
            self._branch()
        target = self.enthalpy + energy
        while len(self.turns) > 2 and (target - self._end > 0.0) == self.heating:
            del self.turns[-2:]  # an inner loop is closed
            self._branch()
        self._place(target)

    def _place(self, target: float) -> None:
        T, H, at = self._T, self._H, self._at
        if not H[at] <= target < H[at + 1]:
            self._at = at = min(max(bisect_right(H, target) - 1, 0), len(H) - 2)
        part = (target - H[at]) / (H[at + 1] - H[at])
        self.temperature = T[at] + part * (T[at + 1] - T[at])
        self.fraction = (target - self._C * self.temperature) / self._L
        self.enthalpy = target

    def _branch(self) -> None:
        """Enthalpy over temperature from the last turning point on."""
        begin, z = self.turns[-1]
        place = min(max((begin - GRID[0]) / (GRID[1] - GRID[0]), 0.0), len(GRID) - 1.001)
        k = int(place)
        part = place - k
        if self.heating:
            change = (1.0 - part) * self._weights[:, k] + part * self._weights[:, k + 1]
        else:
            change = -(1.0 - part) * self._weights[k] - part * self._weights[k + 1]
        z_of = z + np.concatenate([change[:1], change, change[-1:]])
        T_of = np.concatenate([[GRID[0] - BEYOND], GRID, [GRID[-1] + BEYOND]])
        self._T: list[float] = T_of.tolist()
        self._at = 0
        """Index of the last hit, the first guess of the next search."""
        self._H: list[float] = (self._C * T_of + self._L * z_of).tolist()
        if len(self.turns) > 2:
            end, fraction = self.turns[-2]
            self._end = self._C * end + self._L * fraction
