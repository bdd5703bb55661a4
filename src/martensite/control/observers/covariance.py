"""Small covariance matrices as kernels: packing, Cholesky factor, and conditioning on readings.

Unknowns v with covariance C are jointly normal. A reading z = v_i + n with a noise of variance r gives

    S = C_ii + r,   g = C e_i/S,   v + g (z - v_i),   C - S g gᵀ,

the update of a Kalman filter; several readings follow in succession. The sum of (z - v_i)²/S is the normalised
innovation squared (NIS), chi-square distributed with one degree of freedom per reading for a consistent filter.

Source: Bar-Shalom, Li and Kirubarajan (2001), Estimation with Applications to Tracking and Navigation, sections 5.2
and 5.4.
"""

from collections.abc import Sequence
from typing import NamedTuple

from martensite.actuators.mechanics.elimination import multiply_inner
from martensite.kernels.namespace import Namespace, Scalar

Matrix = list[list[Scalar]]
LEAST_VARIANCE = 1e-30
"""Variance that counts as zero."""


class UnknownReading(NamedTuple):
    """Reading of an unknown."""

    index: int
    value: Scalar
    variance: Scalar
    is_used: Scalar
    """1 for a used reading, else 0."""


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
    """Return J C Jᵀ for the rows of J and a symmetric matrix C."""
    half = [[multiply_inner(row, column) for column in matrix] for row in rows]
    below = [[multiply_inner(half[i], rows[j]) for j in range(i + 1)] for i in range(len(rows))]
    return unpack_matrix(pack_matrix(below))


def add_matrices(a: Matrix, b: Matrix) -> Matrix:
    """Return the sum of two matrices."""
    return [[x + y for x, y in zip(r, s, strict=True)] for r, s in zip(a, b, strict=True)]


def factor_cholesky(xp: Namespace, matrix: Matrix) -> Matrix:
    """Return the lower L with L Lᵀ = C; columns of zeros for known directions."""
    size = len(matrix)
    factor: Matrix = [[0.0] * size for _ in range(size)]
    for k in range(size):
        left = matrix[k][k] - multiply_inner(factor[k][:k], factor[k][:k])
        some = left > LEAST_VARIANCE
        pivot = xp.sqrt(xp.where(some, left, 1.0))
        factor[k][k] = xp.where(some, pivot, 0.0)
        for i in range(k + 1, size):
            rest = matrix[i][k] - multiply_inner(factor[i][:k], factor[k][:k])
            factor[i][k] = xp.where(some, rest / pivot, 0.0)
    return factor


def condition_on_readings(
    xp: Namespace, mean: Sequence[Scalar], matrix: Matrix, readings: Sequence[UnknownReading]
) -> tuple[list[Scalar], Matrix, Scalar]:
    """Return unknowns and covariance after readings, and their NIS."""
    unknowns, nis = list(mean), 0.0
    for i, value, variance, used in readings:
        total = matrix[i][i] + variance
        some = total > LEAST_VARIANCE
        inverse = xp.where(some, used / xp.where(some, total, 1.0), 0.0)
        short = value - unknowns[i]
        gain = [row[i] * inverse for row in matrix]
        nis = nis + short * short * inverse
        unknowns = [x + g * short for x, g in zip(unknowns, gain, strict=True)]
        matrix = [[c - g * b for c, b in zip(row, matrix[i], strict=True)] for row, g in zip(matrix, gain, strict=True)]
    return unknowns, unpack_matrix(pack_matrix(matrix)), nis


def put_unknown(xp: Namespace, mean: Sequence[Scalar], matrix: Matrix, index: int, value: Scalar) -> list[Scalar]:
    """Return the unknowns with one of them set to a value; the others follow by correlation."""
    some = matrix[index][index] > LEAST_VARIANCE
    inverse = xp.where(some, 1.0 / xp.where(some, matrix[index][index], 1.0), 0.0)
    way = value - mean[index]
    unknowns = [x + row[index] * inverse * way for x, row in zip(mean, matrix, strict=True)]
    unknowns[index] = value
    return unknowns
