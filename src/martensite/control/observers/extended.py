"""Extended Kalman filter: the model linearised along its trajectory.

    x⁻ = f(x),   v = (x⁻, h(x⁻)),   C = (dv/dx) P (dv/dx)ᵀ + (dv/dx⁻) Q T (dv/dx⁻)ᵀ

Slopes are exact: dual numbers pass through the steps of the period with the whole state and the history of the law. At
a turning point of a hysteresis they are one-sided.

Source: Bar-Shalom, Li and Kirubarajan (2001), section 10.3.
"""

from collections.abc import Sequence
from typing import Any

from martensite.control.observers import covariance, hidden_states
from martensite.control.observers.base import OBSERVERS, ObserverPeriod
from martensite.control.observers.filter import AbstractFilter, FilterMemory, Forecast
from martensite.kernels.dual import DualNamespace
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers

Columns = list[list[Scalar]]


@OBSERVERS.register("extended-kalman")
class ExtendedKalman(AbstractFilter):
    """Temperature and fraction by linearisation (EKF)."""

    cites = ("barshalom2001",)

    def forecast(self, xp: Namespace, before: FilterMemory, period: ObserverPeriod) -> Forecast:
        drift = before.drift
        flat, slopes = self._predict_state(xp, before, period)
        state = NestedShape(before.state).rebuild(flat)
        mean, rows = self._predict_outputs(xp, before, flat, slopes, period)
        matrix = covariance.propagate_covariance(rows, before.covariance)
        added = self.noise_covariance(xp, state, drift, period)
        return Forecast(state, mean, covariance.add_matrices(matrix, added))

    def _predict_state(
        self, xp: Namespace, before: FilterMemory, period: ObserverPeriod
    ) -> tuple[list[Scalar], Columns]:
        """Return the flat state after the period, and its slopes: a column per unknown."""
        shape, count = NestedShape(before.state), self.unknowns()
        model = self.model_at_factors(xp, before.drift)
        at = [*hidden_states.read_hidden(xp, model, before.state, period.signals), *before.drift]
        unknown = len(at) - len(before.drift)
        size = len(flatten_numbers(before.state))

        def start(dual: Any, x: Sequence[Any]) -> list[Any]:
            model = self.model_at_factors(dual, x[unknown:])
            return flatten_numbers(hidden_states.place_hidden(dual, model, before.state, x[:unknown], period.signals))

        def turn(*numbers: Any) -> list[Any]:
            flat, columns = numbers[:size], list[Any]()
            after = list(flat)
            for k in range(count):
                dual: Any = DualNamespace(xp)
                model = self.model_at_factors(dual, _seed_dual(dual, at, k)[unknown:])
                slopes = numbers[size * (k + 1) : size * (k + 2)]
                now = shape.rebuild([dual.pair(x, t) for x, t in zip(flat, slopes, strict=True)])
                then, _ = model.step(dual, now, *period.signals, dt=period.step)
                after, tangents = _separate_dual(dual, flatten_numbers(then))
                columns += tangents
            return [*after, *columns]

        begin = list(flatten_numbers(before.state))
        for k in range(count):
            dual: Any = DualNamespace(xp)
            begin += _separate_dual(dual, start(dual, _seed_dual(dual, at, k)))[1]
        result = turn(*begin) if period.turns == 1 else xp.repeat(period.turns, turn, *begin)
        columns = [list(result[size * (k + 1) : size * (k + 2)]) for k in range(count)]
        return list(result[:size]), columns

    def _predict_outputs(
        self, xp: Namespace, before: FilterMemory, flat: list[Scalar], slopes: Columns, period: ObserverPeriod
    ) -> tuple[list[Scalar], Columns]:
        """Return unknowns and outputs after the period, and their slopes: a row each."""
        shape, columns = NestedShape(before.state), Columns()
        mean: list[Scalar] = []
        unknown = len(slopes) - len(before.drift)
        for k, tangents in enumerate(slopes):
            dual: Any = DualNamespace(xp)
            drift = list(before.drift)
            if k >= unknown:
                drift[k - unknown] = dual.pair(drift[k - unknown], 1.0)
            state = shape.rebuild([dual.pair(x, t) for x, t in zip(flat, tangents, strict=True)])
            mean, column = _separate_dual(dual, self.read_model(dual, state, drift, period.signals))
            columns.append(column)
        return mean, [list(row) for row in zip(*columns, strict=True)]


def _seed_dual(dual: Any, at: Sequence[Any], k: int) -> list[Any]:
    return [dual.pair(x, 1.0) if i == k else x for i, x in enumerate(at)]


def _separate_dual(dual: Any, numbers: Sequence[Any]) -> tuple[list[Any], list[Any]]:
    pairs = [dual.parts(x) for x in numbers]
    return [v for v, _ in pairs], [0.0 if t is None else t for _, t in pairs]
