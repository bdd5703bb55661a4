"""Profile likelihood of a parameter of a fit, with refits of all others.

As for intervals from the Jacobian, the weights of a robust loss stay at their optimum values, and autocorrelated
residuals count as n_eff samples (`uncertainty`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from martensite.base.confidence import LEVEL
from martensite.base.errors import DataError, SolveError, require_known
from martensite.fit.fit import Fit
from martensite.search.least_squares import descend_squares
from martensite.search.profile import MOST_REFITS, Profile, walk_profile

REFIT = 50
"""Evaluations of one refit."""


def profile_likelihood(fit: Fit, name: str, *, level: float = LEVEL, most: int = MOST_REFITS) -> Profile:
    """Compute the profile of a free parameter of a fit.

    Args:
        fit: finished fit.
        name: name of a free parameter.
        level: level of the interval.
        most: largest number of refits on each side.

    Raises:
        UnknownNameError: the free parameter does not exist.
        DataError: there are no more independent samples than parameters.
    """
    names = list(fit.problem.names)
    require_known("free parameter", name, names)
    place, unsure = names.index(name), fit.uncertainty
    freedom = min(int(unsure.effective) - unsure.rank, unsure.freedom)
    if freedom < 1:
        raise DataError(
            f"The profile of `{name}` needs more independent samples than the "
            f"{unsure.effective:.3g} there are for {unsure.rank} parameters."
        )
    free, refit = fit.problem.free[place], _Refit(fit)
    return walk_profile(
        refit,
        fit.values,
        refit.cost(fit.evaluation.residuals),
        place,
        low=0.0,
        high=1.0,
        freedom=freedom,
        level=level,
        step=_choose_first_step(fit, place),
        most=most,
        to_value=free.value,
        name=name,
        unit=free.unit,
    )


def _choose_first_step(fit: Fit, place: int) -> float | None:
    """Return half a standard error, as a fraction of the search range; None if unknown."""
    error = fit.uncertainty.errors[place] * fit.uncertainty.widening
    slope = abs(fit.problem.free[place].slope(fit.values[place]))
    share = 0.5 * error / slope
    return share if 0.0 < share < 0.5 else None


class _Refit:
    """Least cost with some fixed parameters."""

    def __init__(self, fit: Fit) -> None:
        self.problem, self.weights = fit.problem, fit.weights

    def cost(self, residuals: Any) -> float:
        """Return the sum of the squared weighted residuals."""
        return float(np.sum((self.weights * residuals) ** 2))

    def __call__(self, fixed_values: dict[int, float], start: Sequence[float]) -> tuple[Sequence[float], float]:
        """Return all parameters, and the cost."""
        point = np.array(start, float)
        point[list(fixed_values)] = list(fixed_values.values())
        first = self._evaluate(point, False)
        if first is None:
            raise SolveError("The run fails with the parameter held.")
        if len(fixed_values) == len(point):
            return tuple(point), self.cost(first.residuals)
        descent = descend_squares(
            self._evaluate, point, first, most=REFIT, held=list(fixed_values), weights=self.weights
        )
        return tuple(map(float, descent.shares)), 2.0 * descent.cost

    def _evaluate(self, shares: Any, slopes: bool) -> Any:
        return self.problem.evaluate(shares, slopes=slopes)
