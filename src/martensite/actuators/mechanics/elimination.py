"""Small dense linear systems: Gaussian elimination without pivoting.

For matrices with safe diagonals, such as stiffness and inertia matrices.
"""

from collections.abc import Sequence

from martensite.kernels.namespace import Scalar

Rows = Sequence[Sequence[Scalar]]


def solve_linear(matrix: Rows, sides: Rows) -> list[list[Scalar]]:
    """Return the solution x of A x = b for each right-hand side b."""
    a, columns = [list(row) for row in matrix], [list(side) for side in sides]
    size = len(a)
    for k in range(size):
        inverse = 1.0 / a[k][k]
        for i in range(k + 1, size):
            factor = a[i][k] * inverse
            a[i][k + 1 :] = [x - factor * y for x, y in zip(a[i], a[k], strict=True)][k + 1 :]
            for column in columns:
                column[i] = column[i] - factor * column[k]
    for column in columns:
        for k in reversed(range(size)):
            for j in range(k + 1, size):
                column[k] = column[k] - a[k][j] * column[j]
            column[k] = column[k] / a[k][k]
    return columns


def multiply_inner(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    """Return the inner product."""
    result: Scalar = 0.0
    for x, y in zip(a, b, strict=True):
        result = result + x * y
    return result
