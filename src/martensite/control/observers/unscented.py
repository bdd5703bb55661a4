"""Unscented Kalman filter: sigma points pass through the model, without slopes.

    x_0 = x,   x_±i = x ± s L e_i,   P = L Lᵀ,   s² = α² max(3, n)
    w_i = 1/(2 s²),   w_0 = 1 - n/s²         (covariance: w_0 + β)

The points pass through all steps of the period; their ends give mean and covariance of hidden values and outputs. The
noise of the period is added as in the extended filter.

Fractions of the points are limited to [0, 1], which biases a pure phase: in a steady martensite ξ settles 0.01 to 0.02
below 1, between one and two standard deviations.

Source: Julier and Uhlmann (2004), Proc. IEEE 92; s² = n + κ with κ = 3 - n for α = 1.
"""

from collections.abc import Sequence

from martensite.base.parameters import Number, param
from martensite.control.observers import covariance, hidden_states
from martensite.control.observers.base import OBSERVERS, ObserverPeriod
from martensite.control.observers.covariance import Matrix
from martensite.control.observers.filter import AbstractFilter, FilterMemory, Forecast
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers, sum_column

GAUSSIAN = 3
"""s² that matches the fourth moments of a normal distribution."""


@OBSERVERS.register("unscented-kalman")
class UnscentedKalman(AbstractFilter):
    """Temperature and fraction from sigma points (UKF)."""

    cites = ("julier2004",)

    alpha: Number = param("1", "spread of the points", above=0.0, high=2.0, default=1.0)
    beta: Number = param("1", "weight of the middle in the covariance", low=0.0, default=0.0)

    def forecast(self, xp: Namespace, before: FilterMemory, period: ObserverPeriod) -> Forecast:
        rows = self._predict_points(xp, before, period)
        points = self._predict_outputs(xp, rows, before, period)
        mean, matrix = self._moments(points)
        size = len(flatten_numbers(before.state))
        state = NestedShape(before.state).rebuild(rows[0][:size])
        added = self.noise_covariance(xp, state, before.drift, period)
        return Forecast(state, mean, covariance.add_matrices(matrix, added))

    def points(self, xp: Namespace, before: FilterMemory, period: ObserverPeriod) -> Matrix:
        """Return the hidden values and factors of all points, the middle one first."""
        model = self.model_at_factors(xp, before.drift)
        middle = [*hidden_states.read_hidden(xp, model, before.state, period.signals), *before.drift]
        root, far = covariance.factor_cholesky(xp, before.covariance), xp.sqrt(self._square())
        points = [middle]
        for k in range(len(middle)):
            way = [far * row[k] for row in root]
            points.append([x + d for x, d in zip(middle, way, strict=True)])
            points.append([x - d for x, d in zip(middle, way, strict=True)])
        count = len(middle) - len(before.drift)
        return [[*hidden_states.limit_fractions(xp, x[:count]), *self.limit_factors(xp, x[count:])] for x in points]

    def _predict_points(self, xp: Namespace, before: FilterMemory, period: ObserverPeriod) -> Matrix:
        """Return the flat state after the period, and the factors, of every point."""
        shape, size = NestedShape(before.state), len(flatten_numbers(before.state))
        points = self.points(xp, before, period)
        unknown = len(points[0]) - len(before.drift)

        def begin(*x: Scalar) -> list[Scalar]:
            model = self.model_at_factors(xp, x[unknown:])
            state = hidden_states.place_hidden(xp, model, before.state, x[:unknown], period.signals)
            return [*flatten_numbers(state), *x[unknown:]]

        def step(*row: Scalar) -> list[Scalar]:
            model, now = self.model_at_factors(xp, row[size:]), shape.rebuild(row[:size])
            then, _ = model.step(xp, now, *period.signals, dt=period.step)
            return [*flatten_numbers(then), *row[size:]]

        def turn(*numbers: Scalar) -> list[Scalar]:
            columns = _cut_columns(numbers, len(points))
            return [x for column in xp.each(step, *columns) for x in column]

        columns = xp.each(begin, *zip(*points, strict=True))
        flat = [x for column in columns for x in column]
        numbers = turn(*flat) if period.turns == 1 else xp.repeat(period.turns, turn, *flat)
        return [list(row) for row in zip(*_cut_columns(numbers, len(points)), strict=True)]

    def _predict_outputs(self, xp: Namespace, rows: Matrix, before: FilterMemory, period: ObserverPeriod) -> Matrix:
        shape, size = NestedShape(before.state), len(flatten_numbers(before.state))

        def read(*row: Scalar) -> list[Scalar]:
            return self.read_model(xp, shape.rebuild(row[:size]), row[size:], period.signals)

        columns = xp.each(read, *zip(*rows, strict=True))
        return [list(row) for row in zip(*columns, strict=True)]

    def _moments(self, points: Sequence[Sequence[Scalar]]) -> tuple[list[Scalar], Matrix]:
        square = self._square()
        side = 0.5 / square
        middle = 1.0 - 0.5 * (len(points) - 1) / square
        weights = [middle, *[side] * (len(points) - 1)]
        columns = list(zip(*points, strict=True))
        mean = [sum_column([w * x for w, x in zip(weights, c, strict=True)]) for c in columns]
        weights[0] = middle + self.beta
        off = [[x - m for x in c] for c, m in zip(columns, mean, strict=True)]

        def product(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
            return sum_column([w * x * y for w, x, y in zip(weights, a, b, strict=True)])

        below = [product(off[i], off[j]) for i in range(len(off)) for j in range(i + 1)]
        return mean, covariance.unpack_matrix(below)

    def _square(self) -> Scalar:
        return self.alpha * self.alpha * float(max(GAUSSIAN, self.unknowns()))


def _cut_columns(numbers: Sequence[Scalar], count: int) -> list[Sequence[Scalar]]:
    return [numbers[k : k + count] for k in range(0, len(numbers), count)]
