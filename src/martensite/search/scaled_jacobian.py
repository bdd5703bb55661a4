"""Free parameters of a fit as arrays: names, values, search ranges, units."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError, ParameterError

Matrix: TypeAlias = NDArray[np.float64]
Vector: TypeAlias = NDArray[np.float64]
_PROPORTIONAL = 1e-3
_ROUNDING = 1e-15


@dataclass(frozen=True)
class ScaledParameters:
    """Free parameters at the point where a Jacobian was taken."""

    names: tuple[str, ...]
    values: tuple[float, ...]
    """In SI."""
    scales: tuple[float, ...]
    """Change of each value per change of the scaled parameter, which has a range of 1, in SI.

    It is high - low on a linear scale, and value × log(high/low) on a logarithmic scale.
    """
    units: tuple[str, ...]
    """SI unit of each."""

    def __len__(self) -> int:
        return len(self.names)

    def relative(self, place: int, direction: Vector) -> float:
        """Return the change along a direction as a fraction of the value; NaN for a value of 0."""
        value = self.values[place]
        return float(direction[place]) * self.scales[place] / value if value else math.nan

    def jacobian(self, jacobian: Any) -> Matrix:
        """Return the Jacobian per search range as an array, (residuals, parameters).

        Raises:
            DataError: the Jacobian is not finite, or has a wrong number of columns.
        """
        matrix = np.asarray(jacobian, np.float64)
        if matrix.ndim != 2 or matrix.shape[1] != len(self) or not len(matrix):
            raise DataError(
                f"The Jacobian must have one column for each of {len(self)} parameters, "
                f"but has the shape {matrix.shape}."
            )
        if not np.isfinite(matrix).all():
            raise DataError("The Jacobian must be finite, but is not; a run has failed.")
        return matrix


def scale_parameters(
    names: Sequence[str], values: Sequence[float], scales: Sequence[float], units: Sequence[str] | None = None
) -> ScaledParameters:
    """Return free parameters by names, values, scales and units (default: no units).

    Raises:
        ParameterError: the inputs are empty or differ in length, or a scale is 0 or not finite.
    """
    given = units or ["1"] * len(names)
    if not 0 < len(names) == len(values) == len(scales) == len(given):
        raise ParameterError(
            "Names, values, scales and units must have equal lengths of at least 1, but have "
            f"{len(names)}, {len(values)}, {len(scales)} and {len(given)}."
        )
    for name, scale in zip(names, scales, strict=True):
        if scale == 0.0 or not math.isfinite(scale):
            raise ParameterError(f"The scale of `{name}` must not be 0, but is {scale:g}.")
    return ScaledParameters(tuple(names), tuple(map(float, values)), tuple(map(float, scales)), tuple(given))


def is_gauge(relative: Sequence[float]) -> bool:
    """Return whether relative changes of two or more parameters are all equal up to sign."""
    sizes = [abs(one) for one in relative]
    return len(sizes) > 1 and all(abs(s - sizes[0]) <= _PROPORTIONAL * sizes[0] for s in sizes)


def balance_columns(jacobian: Matrix) -> tuple[Matrix, Vector]:
    """Return the columns scaled to norm 1, or zeros for rounding errors, and their norms.

    Dependence of columns must not depend on the search ranges.
    """
    norms = np.linalg.norm(jacobian, axis=0)
    nonzero_columns = norms > _ROUNDING * np.max(norms)
    sizes = np.where(nonzero_columns, norms, 1.0)
    return np.where(nonzero_columns, jacobian / sizes, 0.0), sizes


def reduce_rows(jacobian: Matrix) -> Matrix:
    """Return a square matrix with the same singular values and right vectors."""
    upper: Matrix = np.asarray(np.linalg.qr(jacobian, mode="r"))
    missing = upper.shape[1] - upper.shape[0]
    return np.vstack([upper, np.zeros((missing, upper.shape[1]))])
