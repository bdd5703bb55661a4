"""Preisach hysteresis from its turning points: the classical form, one page, for tests.

E(a, b) is the weight of the relays that switch up at a or below and down at b or above. From a
minimum at b, rising to a adds E(a, b); from a maximum at a, falling to b takes E(a, b) away. Two
turning points are forgotten as soon as the input goes beyond the earlier one of them (wiping
out). Source: Mayergoyz 2003, chapter 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

Everett = Callable[[float, float], float]


class Turning:
    """Output over an input that begins to rise from below all relays."""

    def __init__(self, everett: Everett, x: float, y: float, forgets: bool = True) -> None:
        self.everett, self.forgets = everett, forgets
        self.turns = [(x, y)]
        self.at = (x, y)
        self.upward = True

    def move(self, x: float) -> float:
        """The output after the input has moved to x."""
        if x != self.at[0]:
            upward = x > self.at[0]
            if upward != self.upward:
                self.turns.append(self.at)
                self.upward = upward
            while self.forgets and len(self.turns) > 2 and self._beyond(x):
                del self.turns[-2:]
            turn, y = self.turns[-1]
            change = self.everett(x, turn) if upward else -self.everett(turn, x)
            self.at = (x, y + change)
        return self.at[1]

    def _beyond(self, x: float) -> bool:
        earlier = self.turns[-2][0]
        return x >= earlier if self.upward else x <= earlier

    def simulate(self, inputs: Sequence[float]) -> np.ndarray:
        """Outputs for inputs, one after the other."""
        return np.array([self.move(float(x)) for x in inputs])


def of_plays(radii: Sequence[float], curves: Sequence[Callable[[float], float]]) -> Everett:
    """E of plays through rising curves: relays of half width r on a line, weighted by the slope."""

    def everett(a: float, b: float) -> float:
        parts = ((a - r, b + r, g) for r, g in zip(radii, curves, strict=True))
        return sum(g(top) - g(bottom) for top, bottom, g in parts if top > bottom)

    return everett
