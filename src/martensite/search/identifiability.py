"""Identifiability: the parameters of a model that data determine, and the undetermined ones, in words.

The residuals r of a fit change by J dz if the parameters z, scaled to search ranges of 1, change by dz. With J = U Σ Vᵀ
and independent noise s in every residual, the standard error along the direction v_k is s/σ_k search ranges:

    σ_k = 0    redundant: no data of this kind determine the direction
    σ_k ≤ s    weak: uncertain by more than the whole search range

The threshold for 0 follows from the precision of J with all columns scaled to equal norm. Reports describe each
direction by the smallest set of parameters that move in it (`weak_direction_sets`), to first order. Singular values as
a test of identifiability: Brun, Reichert and Künsch (2001), Water Resources Research 37.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import ParameterError
from martensite.base.formats import choose_difference_unit
from martensite.search.quantity_text import format_number, list_names, round_below
from martensite.search.scaled_jacobian import ScaledParameters, balance_columns, is_gauge, scale_parameters
from martensite.search.weak_direction import WeakDirection, find_weak_directions

Matrix: TypeAlias = NDArray[np.float64]
Vector: TypeAlias = NDArray[np.float64]
PRECISION = 1e-10
"""Relative precision of each column of exact derivatives; take 1e-6 for finite differences."""
NEGLIGIBLE = 0.05
"""Negligible component of a weak direction, as a fraction of the largest component.

It is omitted if the remaining direction is weak without it, within twice the noise.
"""
_TENTH = 0.1


@dataclass(frozen=True)
class Identifiability:
    """Identifiability of the free parameters."""

    names: tuple[str, ...]
    sensitivities: tuple[float, ...]
    """Root-mean-square change of the error over each search range, in units of its noise."""
    singular_values: tuple[float, ...]
    """Singular values of the Jacobian per search range, in descending order."""
    uncertainties: tuple[float, ...]
    """Standard error along each singular direction, in search ranges; infinite for 0."""
    condition: float
    """Ratio of largest to smallest singular value; infinite for redundant parameters."""
    weak: tuple[WeakDirection, ...]
    """Directions that the data do not determine, the exactly redundant ones first."""
    refused: tuple[str, ...] = ()
    """Parameters that count as undetermined for another reason, such as a value at a bound."""

    @property
    def determined(self) -> bool:
        """Return whether every direction is determined better than the search range, with no parameter rejected."""
        return not self.weak and not self.refused

    @property
    def without_effect(self) -> tuple[str, ...]:
        """Return the parameters without any effect."""
        return tuple(one.names[0] for one in self.weak if one.exact and len(one.names) == 1)

    @property
    def sentences(self) -> tuple[str, ...]:
        """Return one sentence for each undetermined direction; otherwise that all are determined."""
        if self.weak:
            return tuple(one.sentence for one in self.weak)
        names = [name for name in self.names if name not in self.refused]
        if self.refused:
            return (f"{list_names(names) or 'No parameter'} {_is_or_are(names)} determined.",)
        worst = format_number(100.0 * max(self.uncertainties), 2)
        subject = "All parameters are" if len(names) > 1 else f"{list_names(names)} is"
        return (f"{subject} determined. The least certain direction has an error of {worst} % of the search range.",)

    def to_dict(self) -> dict[str, Any]:
        """Return all values by name and the sentences, for JSON."""
        return {
            "sensitivities": dict(zip(self.names, self.sensitivities, strict=True)),
            "singular_values": list(self.singular_values),
            "condition": self.condition,
            "determined": self.determined,
            "weak": [one.to_dict() for one in self.weak],
            "sentences": list(self.sentences),
        }


def _is_or_are(names: Sequence[str]) -> str:
    return "are" if len(names) > 1 else "is"


def assess_identifiability(
    jacobian: Any,
    names: Sequence[str],
    *,
    values: Sequence[float],
    scales: Sequence[float],
    units: Sequence[str] | None = None,
    noise: float = 1.0,
    precision: float = PRECISION,
) -> Identifiability:
    """Assess a Jacobian of weighted residuals.

    Args:
        jacobian: (residuals, parameters), change of each residual per search range.
        names: names of the parameters.
        values: values of the parameters at the Jacobian, in SI.
        scales: change of each value per search range, in SI (see `Axes`).
        units: SI unit of each parameter, by default none.
        noise: standard deviation of a weighted residual, 1 if weighted by the true noise.
        precision: relative precision of each column of the Jacobian.

    Raises:
        DataError: the Jacobian is not finite, or has a wrong number of columns.
        ParameterError: the noise is not above 0, or values and names differ in length.
    """
    free = scale_parameters(names, values, scales, units)
    matrix = free.jacobian(jacobian)
    if not 0.0 < noise < math.inf:
        raise ParameterError(f"Argument `noise` must be above 0, but is {noise:g}.")
    sizes = np.zeros(len(free))
    singular_values = np.linalg.svd(matrix, compute_uv=False)
    sizes[: len(singular_values)] = singular_values
    directions = _find_directions(matrix, free, noise, precision)
    rank = len(free) - sum(one.exact for one in directions)
    spread = np.linalg.norm(matrix, axis=0) / (noise * math.sqrt(len(matrix)))
    return Identifiability(
        free.names,
        tuple(map(float, spread)),
        tuple(map(float, sizes)),
        tuple(noise / s if k < rank and s else math.inf for k, s in enumerate(map(float, sizes))),
        float(sizes[0] / sizes[-1]) if rank == len(free) and sizes[-1] else math.inf,
        directions,
    )


def _find_directions(
    matrix: Matrix, free: ScaledParameters, noise: float, precision: float
) -> tuple[WeakDirection, ...]:
    """Return the redundant, then the weak directions, each with the fewest parameters."""

    def gauge(direction: Vector) -> bool:
        moves = [i for i in range(len(free)) if direction[i] != 0.0]
        return is_gauge([free.relative(i, direction) for i in moves])

    columns, norms = balance_columns(matrix)
    nothing = precision * float(np.linalg.norm(columns, 2))
    exact = find_weak_directions(columns, nothing, prefer=lambda v: gauge(v / norms))
    exact = [v / norms / np.linalg.norm(v / norms) for v in exact]
    weak = find_weak_directions(matrix, noise, exact, gauge)
    directions = [_describe_direction(matrix, free, v, noise, True) for v in exact]
    directions += [_describe_direction(matrix, free, _drop_negligible(matrix, v, noise), noise, False) for v in weak]
    return tuple(directions)


def _drop_negligible(matrix: Matrix, direction: Vector, limit: float) -> Vector:
    large = np.abs(direction) >= NEGLIGIBLE * np.max(np.abs(direction))
    short = np.where(large, direction, 0.0)
    return short if np.linalg.norm(matrix @ short) <= 2.0 * limit else direction


def _describe_direction(
    matrix: Matrix, free: ScaledParameters, direction: Vector, noise: float, exact: bool
) -> WeakDirection:
    """Return a unit vector per search range as parameters and amounts."""
    order = sorted(np.flatnonzero(direction).tolist(), key=lambda i: -abs(float(direction[i])))
    moved = direction * _choose_stretch(free, direction, order)
    effect = float(np.linalg.norm(matrix @ direction))
    return WeakDirection(
        tuple(free.names[i] for i in order),
        tuple(free.units[i] for i in order),
        tuple(float(moved[i]) * free.scales[i] for i in order),
        tuple(free.relative(i, moved) for i in order),
        noise / effect if effect and not exact else math.inf,
        float(np.linalg.norm(matrix @ moved)) / (noise * math.sqrt(len(matrix))),
        exact,
    )


def _choose_stretch(free: ScaledParameters, direction: Vector, order: Sequence[int]) -> float:
    """Return the factor that gives the largest component a round change, up to half its range."""
    first = order[0]
    rise = float(direction[first]) * free.scales[first]
    if len(order) == 1:
        return abs(free.scales[first]) / rise
    if is_gauge([free.relative(i, direction) for i in order]):
        return _TENTH / free.relative(first, direction)
    _, factor = choose_difference_unit(free.units[first])
    return round_below(0.5 * abs(free.scales[first]) / factor) * factor / rise
