"""Small covariance matrices, written out: packed, factored, and conditioned on readings.

Unknowns v with covariance C are jointly normal. A reading z = v_i + n of one of them, with a noise of variance r, makes

    S = C_ii + r,   g = C e_i/S,   v + g (z - v_i),   C - S g gᵀ,

which is the update of a Kalman filter for one reading; several follow one after the other.
Sum of (z - v_i)²/S: the normalised innovation squared (NIS), chi-square distributed with as many
degrees of freedom as there are readings if the filter is consistent.

Source: Bar-Shalom, Li and Kirubarajan (2001), Estimation with Applications to Tracking and
Navigation, sections 5.2 and 5.4.
"""

from collections.abc import Sequence
from typing import NamedTuple

from martensite.actuators.mechanics.elimination import multiply_inner
from martensite.kernels.namespace import Namespace, Scalar

Matrix = list[list[Scalar]]
LEAST_VARIANCE = 1e-30
"""Variance below which nothing is unknown."""


class UnknownReading(NamedTuple):
    """Reading of one of the unknowns."""

    index: int
    value: Scalar
    variance: Scalar
    used: Scalar
    """1 if it counts, else 0."""


def pack_matrix(matrix: Matrix) -> list[Scalar]:
    """Return the lower triangle of a symmetric matrix, row by row."""
    return [x for i, row in enumerate(matrix) for x in row[: i + 1]]


def unpack_matrix(numbers: Sequence[Scalar]) -> Matrix:
    """Return the symmetric matrix of a lower triangle."""
    size = int((2 * len(numbers)) ** 0.5)
    start = [k * (k + 1) // 2 for k in range(size)]
    return [[numbers[start[max(i, j)] + min(i, j)] for j in range(size)] for i in range(size)]


def build_diagonal(numbers: Sequence[Scalar]) -> Matrix:
    """Return a diagonal matrix."""
    return [[x if i == j else 0.0 for j in range(len(numbers))] for i, x in enumerate(numbers)]


def propagate_covariance(rows: Matrix, matrix: Matrix) -> Matrix:
    """J C Jᵀ of a symmetric matrix."""
    half = [[multiply_inner(row, column) for column in matrix] for row in rows]
    below = [[multiply_inner(half[i], rows[j]) for j in range(i + 1)] for i in range(len(rows))]
    return unpack_matrix(pack_matrix(below))


def add_matrices(a: Matrix, b: Matrix) -> Matrix:
    """Return the sum of two matrices."""
    return [[x + y for x, y in zip(r, s, strict=True)] for r, s in zip(a, b, strict=True)]


def factor_cholesky(xp: Namespace, matrix: Matrix) -> Matrix:
    """L with L Lᵀ = C, lower; a column of zeros where nothing is left unknown."""
    size = len(matrix)
    found: Matrix = [[0.0] * size for _ in range(size)]
    for k in range(size):
        left = matrix[k][k] - multiply_inner(found[k][:k], found[k][:k])
        some = left > LEAST_VARIANCE
        root = xp.sqrt(xp.where(some, left, 1.0))
        found[k][k] = xp.where(some, root, 0.0)
        for i in range(k + 1, size):
            rest = matrix[i][k] - multiply_inner(found[i][:k], found[k][:k])
            found[i][k] = xp.where(some, rest / root, 0.0)
    return found


def condition_on_readings(
    xp: Namespace, mean: Sequence[Scalar], matrix: Matrix, readings: Sequence[UnknownReading]
) -> tuple[list[Scalar], Matrix, Scalar]:
    """Return the unknowns and covariance after readings, and their NIS."""
    found, nis = list(mean), 0.0
    for i, value, variance, used in readings:
        total = matrix[i][i] + variance
        some = total > LEAST_VARIANCE
        inverse = xp.where(some, used / xp.where(some, total, 1.0), 0.0)
        short = value - found[i]
        gain = [row[i] * inverse for row in matrix]
        nis = nis + short * short * inverse
        found = [x + g * short for x, g in zip(found, gain, strict=True)]
        matrix = [[c - g * b for c, b in zip(row, matrix[i], strict=True)] for row, g in zip(matrix, gain, strict=True)]
    return found, unpack_matrix(pack_matrix(matrix)), nis


def put_unknown(xp: Namespace, mean: Sequence[Scalar], matrix: Matrix, index: int, value: Scalar) -> list[Scalar]:
    """Return the unknowns of which one is put at a value; the others follow as they are correlated."""
    some = matrix[index][index] > LEAST_VARIANCE
    inverse = xp.where(some, 1.0 / xp.where(some, matrix[index][index], 1.0), 0.0)
    way = value - mean[index]
    found = [x + row[index] * inverse * way for x, row in zip(mean, matrix, strict=True)]
    found[index] = value
    return found
