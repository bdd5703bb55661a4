"""Hysteresis of a wire as a Preisach model in Everett form, heated by energy.

    heating from the last minimum     z = z_m + E(T, T_m)
    cooling from the last maximum     z = z_M - E(T_M, T)

E(a, b) is the weight of the relays that switch up at or below a and down at or above b. Turning points are on a stack;
beyond the previous one, an inner loop is closed and removed. The branches give E only where one temperature is an end
of the major loop. Elsewhere E belongs to relays whose thresholds have a Gaussian copula; its correlation shapes minor
loops only.

A wire with latent heat is stepped by its enthalpy H(T) = C T + ΔH z(T), which rises along each branch: heat gives the
new H, and T follows without iteration.
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
"""Smallest distance of the thresholds of a relay [K]."""
SMOOTHING = 5.0
"""Standard deviation of the smoothing of relays, in steps of the grid."""
BEYOND = 2000.0
"""Distance outside the grid at which transformation ends [K]."""


@lru_cache(4)
def everett_function(share: float, correlation: float) -> Numbers:
    """Return E(a, b) on `GRID`, rows a, columns b, for branches between 50 and 100 MPa."""
    loop = branches.build_loop(share)
    rng = np.random.default_rng(SEED)
    first = rng.standard_normal(RELAYS)
    second = correlation * first + np.sqrt(1.0 - correlation**2) * rng.standard_normal(RELAYS)
    up = branches.invert_branch(loop.heating, ndtr(first))
    down = np.minimum(branches.invert_branch(loop.cooling, ndtr(second)), up - APART)
    weights = gaussian_filter(np.histogram2d(up, down, bins=(GRID, GRID))[0], SMOOTHING)
    # weights beyond the diagonal are mirrored back, so that E is 0 there
    weights = np.tril(weights, -1) + np.triu(weights, 1).T
    count = len(GRID)
    everett = np.zeros((count, count))
    everett[1:, :-1] = (weights / weights.sum()).cumsum(axis=0)[:, ::-1].cumsum(axis=1)[:, ::-1]
    return everett


class Cell:
    """A piece of wire at one temperature: temperature, fraction, and turning points."""

    def __init__(self, weights: Numbers, capacity: float, latent: float, temperature: float) -> None:
        """Start on the heating branch.

        Args:
            weights: E on the grid.
            capacity: C, per metre or of the piece [J/K].
            latent: ΔH, likewise [J].
            temperature: start temperature [K].
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
        """Add heat (negative to remove it), in the unit of the latent heat."""
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
        """Compute the enthalpy over temperature from the last turning point."""
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
        """Index of the last interval, the first guess of the next search."""
        self._H: list[float] = (self._C * T_of + self._L * z_of).tolist()
        if len(self.turns) > 2:
            end, fraction = self.turns[-2]
            self._end = self._C * end + self._L * fraction
