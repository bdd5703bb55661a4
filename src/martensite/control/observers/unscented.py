"""Unscented Kalman filter: sigma points go through the model, no slope is asked for.

    x_0 = x,   x_±i = x ± s L e_i,   P = L Lᵀ,   s² = α² max(3, n)
    w_i = 1/(2 s²),   w_0 = 1 - n/s²         (covariance: w_0 + β)

The points go through all steps of the period; from where they end come mean and covariance of
hidden values and outputs together. The noise of the period is added as for the extended filter.
Points whose fraction would leave [0, 1] begin at its end, which pulls the mean off a pure phase:
at rest in martensite ξ settles 0.01 to 0.02 below 1, between one and two of its deviations.

Source: Julier and Uhlmann (2004), Proc. IEEE 92; s² = n + κ with κ = 3 - n for α = 1.
"""

from collections.abc import Sequence

from martensite.base.parameters import Number, param
from martensite.control.observers import covariance, hidden_states
from martensite.control.observers.base import OBSERVERS, ObserverPeriod
from martensite.control.observers.covariance import Matrix
from martensite.control.observers.filter import AbstractFilter, Believed, Forecast
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers, sum_column

GAUSSIAN = 3
"""s² with which the fourth moments of a normal distribution are met."""


@OBSERVERS.register("unscented-kalman")
class UnscentedKalman(AbstractFilter):
    """Temperature and fraction from sigma points (UKF)."""

    cites = ("julier2004",)

    alpha: Number = param("1", "how far the points are apart", above=0.0, high=2.0, default=1.0)
    beta: Number = param("1", "weight of the middle in the covariance", low=0.0, default=0.0)

    def forecast(self, xp: Namespace, before: Believed, going: ObserverPeriod) -> Forecast:
        """Return the mean and covariance a period later."""
        rows = self._predict_points(xp, before, going)
        seen = self._predict_outputs(xp, rows, before, going)
        mean, matrix = self._moments(seen)
        size = len(flatten_numbers(before.state))
        state = NestedShape(before.state).rebuild(rows[0][:size])
        added = self.noise_covariance(xp, state, before.drift, going)
        return Forecast(state, mean, covariance.add_matrices(matrix, added))

    def points(self, xp: Namespace, before: Believed, going: ObserverPeriod) -> Matrix:
        """Return the hidden values and factors of all points, the middle one first."""
        model = self.model_at_factors(xp, before.drift)
        middle = [*hidden_states.read_hidden(xp, model, before.state, going.signals), *before.drift]
        root, far = covariance.factor_cholesky(xp, before.covariance), xp.sqrt(self._square())
        found = [middle]
        for k in range(len(middle)):
            way = [far * row[k] for row in root]
            found.append([x + d for x, d in zip(middle, way, strict=True)])
            found.append([x - d for x, d in zip(middle, way, strict=True)])
        count = len(middle) - len(before.drift)
        return [[*hidden_states.limit_fractions(xp, x[:count]), *self.limit_factors(xp, x[count:])] for x in found]

    def _predict_points(self, xp: Namespace, before: Believed, going: ObserverPeriod) -> Matrix:
        """Flat state at the end of the period, and factors, of every point."""
        shape, size = NestedShape(before.state), len(flatten_numbers(before.state))
        points = self.points(xp, before, going)
        unknown = len(points[0]) - len(before.drift)

        def begin(*x: Scalar) -> list[Scalar]:
            model = self.model_at_factors(xp, x[unknown:])
            state = hidden_states.place_hidden(xp, model, before.state, x[:unknown], going.signals)
            return [*flatten_numbers(state), *x[unknown:]]

        def step(*row: Scalar) -> list[Scalar]:
            model, now = self.model_at_factors(xp, row[size:]), shape.rebuild(row[:size])
            then, _ = model.step(xp, now, *going.signals, dt=going.step)
            return [*flatten_numbers(then), *row[size:]]

        def turn(*numbers: Scalar) -> list[Scalar]:
            columns = _cut_columns(numbers, len(points))
            return [x for column in xp.each(step, *columns) for x in column]

        columns = xp.each(begin, *zip(*points, strict=True))
        flat = [x for column in columns for x in column]
        found = turn(*flat) if going.turns == 1 else xp.repeat(going.turns, turn, *flat)
        return [list(row) for row in zip(*_cut_columns(found, len(points)), strict=True)]

    def _predict_outputs(self, xp: Namespace, rows: Matrix, before: Believed, going: ObserverPeriod) -> Matrix:
        """Return the hidden values, factors and outputs of every point."""
        shape, size = NestedShape(before.state), len(flatten_numbers(before.state))

        def told(*row: Scalar) -> list[Scalar]:
            return self.read_model(xp, shape.rebuild(row[:size]), row[size:], going.signals)

        columns = xp.each(told, *zip(*rows, strict=True))
        return [list(row) for row in zip(*columns, strict=True)]

    def _moments(self, seen: Sequence[Sequence[Scalar]]) -> tuple[list[Scalar], Matrix]:
        square = self._square()
        side = 0.5 / square
        middle = 1.0 - 0.5 * (len(seen) - 1) / square
        weights = [middle, *[side] * (len(seen) - 1)]
        columns = list(zip(*seen, strict=True))
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
