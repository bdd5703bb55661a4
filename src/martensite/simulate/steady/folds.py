r"""Folds of solution curves in two parameters.

At a fold the Jacobian F_x of the unknowns without the parameters has a singular value σ = w^T F_x v that passes 0,
with unit vectors w and v. Its derivatives need a single second derivative of the model,

∂σ/∂z_j = w^T (∂F_x/∂z_j) v,

which is the change of the Jacobian along v, computed by differences. The equations (F, σ) = 0 define a curve in the
unknowns and both parameters. A fold of this curve is a cusp, at which two folds meet.

Source: Govaerts (2000), Numerical methods for bifurcations of dynamical equilibria, chapter 4.
"""

from __future__ import annotations

import numpy as np

from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.steady.continuation import Equations, LinearisedEquations, correct_point

NUDGE = 1e-4
"""Increment along v for differences of the Jacobian, in sizes."""


class FoldEquations:
    """Fold equations with two parameters as last unknowns; the last one is followed."""

    def __init__(self, equations: Equations) -> None:
        self.equations = equations
        self._pair: tuple[Numbers, Numbers] | None = None

    def linearise(self, point: Numbers) -> LinearisedEquations:
        """Return F and σ with their derivatives."""
        linear = self.equations.linearise(point)
        matrix = (linear.jacobian * linear.sizes)[:, :-2]
        right, left = self._pair = self._find_pair(matrix)
        nudge = NUDGE * np.append(right, [0.0, 0.0]) * linear.sizes
        ahead, behind = (self.equations.linearise(point + sign * nudge).jacobian for sign in (1.0, -1.0))
        change = left @ (ahead - behind) / (2.0 * NUDGE)
        residual = np.append(linear.residual, left @ matrix @ right)
        return LinearisedEquations(residual, np.vstack([linear.jacobian, change]), linear.sizes)

    def _find_pair(self, matrix: Numbers) -> tuple[Numbers, Numbers]:
        """Return v and w of the singular value nearest to the previous one, or of the smallest."""
        columns, singular, rows = np.linalg.svd(matrix)
        count = len(singular)
        if self._pair is None:
            place = count - 1
            return rows[place], columns[:, place]
        right, left = self._pair
        place = int(np.argmax(np.abs(rows[:count] @ right)))
        return np.copysign(1.0, rows[place] @ right) * rows[place], np.copysign(
            1.0, columns[:, place] @ left
        ) * columns[:, place]


def find_fold(equations: FoldEquations, guess: Numbers, second: float) -> Numbers:
    """Return the fold near a point of a curve, at a value of the second parameter.

    Raises:
        SolveError: no fold is nearby.
    """
    normal = np.zeros(len(guess) + 1)
    normal[-1] = 1.0
    return correct_point(equations, np.append(guess, second), normal)[0]
