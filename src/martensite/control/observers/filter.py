"""Common parts of Kalman filters: temperature and fraction of a model, and their covariance.

    x = (T, ξ) at every port, and factors of drifting parameters;      P = cov(x)
    x⁻ = f(x) over a period under the applied signals,   + noise of variance Q T
    y = h(x⁻): outputs of the model; outputs named in `measured` are compared with readings

f is the step of the model and h its `observe`, so filter and plant share their physics. Readings correct x and outputs
in proportion to their correlation (`covariance`); a fraction outside [0, 1] is set to its limit, and the rest
follows. The state of the model keeps its history (`hidden_states`). A reading older than `oldest` is not used.

The noise of a reading has the variance (ρ h)² + σ², with the relative noise ρ and the deviation σ in SI. Drifting
parameters are estimated as factors of the model's values, as random walks.

Sources: Bar-Shalom, Li and Kirubarajan (2001), sections 5.2 and 10.3. The sizes of the noise are assumed;
`martensite.control.loop.consistency` tests them.

Estimates are hidden states, drifting parameters, outputs named in `wanted` (default: coordinates, strain and readings),
each with its standard deviation `NAME_std`, the correlations of hidden states and parameters, and the normalised
innovation squared `nis`, 0 without a reading.
"""

from abc import abstractmethod
from collections.abc import Sequence
from itertools import combinations
from typing import Any, NamedTuple

from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param, text
from martensite.base.units import DEGREES, DIFFERENCE, of_reading
from martensite.control.observers import covariance, hidden_states
from martensite.control.observers.base import (
    AbstractObserver,
    Column,
    Named,
    ObserverPeriod,
    list_required,
    list_several,
    require_outputs,
)
from martensite.control.observers.covariance import Matrix, UnknownReading
from martensite.kernels.dual import compute_jacobian
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers

LEAST_FACTOR, MOST_FACTOR = 0.2, 5.0
"""Limits of factors."""
FAR = 4.0
"""Limit of logarithms and offsets over their initial standard deviation."""
PERIOD_TOLERANCE = 1e-9
"""Fraction of a period that is rounding."""
CORRELATION = "correlation"


class FreeParameter(NamedTuple):
    """An estimated parameter of the model, or several that move together."""

    paths: tuple[str, ...]
    scale: str
    """Meaning of the estimate: a `factor` f, v = v₀ f; a `logarithm` x, v = v₀ exp x; an `offset` x, v = v₀ + x."""
    first: Scalar
    """Initial standard deviation of f or x."""
    walk: Scalar
    """Density of its random walk [1/s^0.5]."""
    opposite: tuple[str, ...] = ()
    """Parameters that change by the opposite offset."""
    far: Scalar = FAR
    """Limit of a logarithm or an offset over its initial standard deviation."""
    surprised: Scalar = 0.0
    """Additional random walk while readings contradict the model [1/s^0.5]."""

    @property
    def path(self) -> str:
        """Return the path of the displayed parameter."""
        return self.paths[0]

    @property
    def start(self) -> float:
        """Return the initial value of f or x."""
        return 1.0 if self.scale == "factor" else 0.0

    def limit(self, xp: Namespace, x: Scalar) -> Scalar:
        """Return an estimate within its limits."""
        if self.scale == "factor":
            return xp.clip(x, LEAST_FACTOR, MOST_FACTOR)
        far = self.far * self.first
        return xp.clip(x, -far, far)

    def values(self, xp: Namespace, model: Named, x: Scalar) -> list[tuple[str, Scalar]]:
        """Return all its parameters by path, from the values of the model."""
        values = [(path, self._at(xp, model[path], x)) for path in self.paths]
        return values + [(path, model[path] - x) for path in self.opposite]

    def size(self, xp: Namespace, model: Named, x: Scalar) -> Scalar:
        """Return the derivative of the parameter with respect to f or x."""
        if self.scale == "offset":
            return 1.0
        value = model[self.path]
        return xp.abs(value if self.scale == "factor" else self._at(xp, value, x))

    def _at(self, xp: Namespace, value: Scalar, x: Scalar) -> Scalar:
        if self.scale == "offset":
            return value + x
        return x * value if self.scale == "factor" else value * xp.exp(x)


class FilterMemory(NamedTuple):
    """Memory of a filter."""

    state: Any
    drift: tuple[Scalar, ...]
    covariance: Matrix


class Forecast(NamedTuple):
    """Prediction of a sample, or its correction by readings."""

    state: Any
    mean: list[Scalar]
    """Hidden values, factors of parameters, then outputs."""
    covariance: Matrix


class AbstractFilter(AbstractObserver):
    """Interface of a Kalman filter; a subclass adds `forecast`."""

    names_reading = ("measured",)

    measured: tuple[str, ...] = text("used readings, named as the outputs of the model", default=("resistance",))
    wanted: tuple[str, ...] = text("estimated outputs; default: coordinates, strain and readings", default=())
    drifting: tuple[str, ...] = text("estimated parameters of the model", default=())
    reading_noise: Number = param("1", "relative standard deviation of readings", low=0.0, default=0.01)
    reading_deviation: Number = param(
        DIFFERENCE, "constant standard deviation of readings; in SI if units differ", low=0.0, default=0.0
    )
    temperature_noise: Number = param("K/s^0.5", "random walk of the temperature", low=0.0, default=0.5)
    fraction_noise: Number = param("1/s^0.5", "random walk of the martensite fraction", low=0.0, default=0.02)
    drift_noise: Number = param("1/s^0.5", "relative random walk of drifting parameters", low=0.0, default=1e-3)
    first_temperature: Number = param(DEGREES, "standard deviation of temperature at the start", low=0.0, default=1.0)
    first_fraction: Number = param("1", "standard deviation of the fraction at the start", low=0.0, default=0.02)
    first_drift: Number = param(
        "1", "relative standard deviation of drifting parameters at the start", low=0.0, default=0.02
    )
    oldest: Number = param("s", "age up to which a reading is used", low=0.0, default=0.0)

    def check(self) -> None:
        require_outputs(self, (*self.reads(), *list_several(self.wanted)))
        self.__dict__["_example"] = hidden_states.build_example(self.model)
        for one in self.free_parameters():
            if one.scale != "offset" and self.model.value_of(one.path) == 0.0:
                raise ParameterError(f"Parameter `{one.path}` cannot drift: it is 0, and drifts by a factor.")

    def reads(self) -> tuple[str, ...]:
        return list_several(self.measured)

    def shown_outputs(self) -> list[str]:
        """Return the estimated outputs of the model."""
        strains = [self.model.label(port, "strain") for port in self.model.actuators()]
        chosen = list_several(self.wanted) or (*self.model.mechanism.outputs(), *strains)
        hidden = hidden_states.list_names(self.model)
        return [name for name in dict.fromkeys((*chosen, *self.reads())) if name not in hidden]

    def estimates(self) -> dict[str, Output]:
        outputs = self.model.outputs()
        leaves = {leaf.path: leaf.declared for leaf in self.model.leaves()}
        estimated = {name: outputs[name] for name in hidden_states.list_names(self.model)}
        free = [one.path for one in self.free_parameters()]
        estimated |= {p: Output(leaves[p].unit, leaves[p].doc, p) for p in free}
        core = list(estimated)
        estimated |= {name: outputs[name] for name in self.shown_outputs()}
        estimated |= {f"{name}_std": _find_deviation(output) for name, output in list(estimated.items())}
        for a, b in combinations(core, 2):
            estimated[f"{CORRELATION}.{a}.{b}"] = Output("1", f"correlation of {a} and {b}", "ρ")
        return estimated | {"nis": Output("1", "normalised innovation squared", "NIS")}

    def free_parameters(self) -> list[FreeParameter]:
        """Return the estimated parameters of the model: by default the drifting ones, as factors."""
        paths = [self.model.resolve(name) for name in list_several(self.drifting)]
        return [FreeParameter((path,), "factor", self.first_drift, self.drift_noise) for path in paths]

    @abstractmethod
    def forecast(self, xp: Namespace, before: FilterMemory, period: ObserverPeriod) -> Forecast:
        """Return the prediction after a period."""

    def rest(self, xp: Namespace, readings: Named, signals: Named) -> tuple[Column, Column]:
        return self.list_estimates(xp, self.first_forecast(xp, list_required(self, signals)), 0.0)

    def first_forecast(self, xp: Namespace, signals: Column) -> Forecast:
        """Return the prediction of the steady state."""
        state = self.model.init(xp, *signals)
        drift = tuple(one.start for one in self.free_parameters())
        matrix = self.first_covariance(xp, [x * x for x in self.first_deviations()], signals)
        mean, slopes = self.outlook(xp, state, drift, signals)
        return Forecast(state, mean, covariance.propagate_covariance(slopes, matrix))

    def first_deviations(self) -> list[Scalar]:
        """Return the initial standard deviations of all unknowns."""
        own = [self.first_temperature, self.first_fraction] * len(self.model.actuators())
        return [*own, *(one.first for one in self.free_parameters())]

    def first_covariance(self, xp: Namespace, variances: Sequence[Scalar], signals: Column) -> Matrix:
        """Return the initial covariance of the unknowns, by default uncorrelated."""
        return covariance.build_diagonal(variances)

    def update(
        self, xp: Namespace, memory: Column, readings: Named, signals: Named, dt: Scalar, turns: int
    ) -> tuple[Column, Column]:
        period = ObserverPeriod(list_required(self, signals), dt, turns)
        expected = self.forecast(xp, self.unflatten_memory(memory), period)
        rows = self.pair_readings(xp, expected.mean, readings, dt)
        mean, matrix, nis = covariance.condition_on_readings(xp, expected.mean, expected.covariance, rows)
        return self.list_estimates(xp, self.place_unknowns(xp, expected.state, mean, matrix, period), nis)

    def place_unknowns(
        self, xp: Namespace, state: Any, mean: list[Scalar], matrix: Matrix, period: ObserverPeriod
    ) -> Forecast:
        """Return the unknowns within their limits, and the corresponding state."""
        for i in range(1, 2 * len(self.model.actuators()), 2):
            mean = covariance.put_unknown(xp, mean, matrix, i, xp.clip(mean[i], 0.0, 1.0))
        hidden, count = len(hidden_states.list_names(self.model)), self.unknowns()
        mean[hidden:count] = self.limit_factors(xp, mean[hidden:count])
        model = self.model_at_factors(xp, mean[hidden:count])
        there = hidden_states.place_hidden(xp, model, state, mean[:hidden], period.signals)
        return Forecast(there, mean, matrix)

    def pair_readings(self, xp: Namespace, mean: Sequence[Scalar], readings: Named, dt: Scalar) -> list[UnknownReading]:
        """Return the readings with their places, variances and use."""
        names, rows = self._rows(), list[UnknownReading]()
        for name in self.reads():
            i = names.index(name)
            size, age = self.reading_noise * mean[i], readings[f"{name}.age"]
            variance = size * size + self.reading_deviation * self.reading_deviation
            fresh = xp.where(age <= self.oldest + PERIOD_TOLERANCE * dt, 1.0, 0.0)
            rows.append(UnknownReading(i, readings[name], variance, fresh))
        return rows

    def _rows(self) -> list[str]:
        free = [one.path for one in self.free_parameters()]
        return [*hidden_states.list_names(self.model), *free, *self.shown_outputs()]

    def unknowns(self) -> int:
        """Return the number of hidden values and drifting parameters."""
        return len(hidden_states.list_names(self.model)) + len(self.free_parameters())

    def model_at_factors(self, xp: Namespace, drift: Sequence[Scalar]) -> Any:
        """Return the model with its estimated parameters."""
        rows = zip(self.free_parameters(), drift, strict=True)
        values = self._model_values()
        return self.model.rebuilt({path: value for one, x in rows for path, value in one.values(xp, values, x)})

    def _model_values(self) -> dict[str, Scalar]:
        return {leaf.path: leaf.value for leaf in self.model.leaves()}

    def limit_factors(self, xp: Namespace, drift: Sequence[Scalar]) -> list[Scalar]:
        """Return the estimates of parameters within their limits."""
        return [one.limit(xp, x) for one, x in zip(self.free_parameters(), drift, strict=True)]

    def read_model(self, xp: Namespace, state: Any, drift: Sequence[Scalar], signals: Column) -> list[Scalar]:
        """Return the hidden values, factors and outputs of a state."""
        outputs = hidden_states.observe_model(xp, self.model_at_factors(xp, drift), state, signals)
        hidden = [outputs[name] for name in hidden_states.list_names(self.model)]
        return [*hidden, *drift, *(outputs[name] for name in self.shown_outputs())]

    def outlook(
        self, xp: Namespace, state: Any, drift: Sequence[Scalar], signals: Column
    ) -> tuple[list[Scalar], Matrix]:
        """Return hidden values, factors and outputs, and their slopes with respect to hidden values and factors."""
        at = hidden_states.read_hidden(xp, self.model_at_factors(xp, drift), state, signals)
        count = len(at)

        def from_unknowns(xp: Namespace, x: Sequence[Scalar]) -> Sequence[Scalar]:
            model = self.model_at_factors(xp, x[count:])
            there = hidden_states.place_hidden(xp, model, state, x[:count], signals)
            return [*x, *self.read_model(xp, there, x[count:], signals)[len(x) :]]

        return compute_jacobian(xp, from_unknowns, [*at, *drift])

    def noise_covariance(self, xp: Namespace, state: Any, drift: Sequence[Scalar], period: ObserverPeriod) -> Matrix:
        """Return the covariance that the noise of a period adds."""
        mean, slopes = self.outlook(xp, state, drift, period.signals)
        own = [period.learning * one.walk + period.surprise * one.surprised for one in self.free_parameters()]
        walks = [*self.hidden_walks(xp, mean, period), *own]
        return covariance.propagate_covariance(slopes, covariance.build_diagonal([w * w * period.dt for w in walks]))

    def hidden_walks(self, xp: Namespace, at: Sequence[Scalar], period: ObserverPeriod) -> list[Scalar]:
        """Return the random walks of temperature and fraction at every port, at their values `at`."""
        return [self.temperature_noise, self.fraction_noise] * len(self.model.actuators())

    def unflatten_memory(self, memory: Column) -> FilterMemory:
        """Return the named memory from a flat column."""
        shape = NestedShape(self.__dict__["_example"])
        size = len(flatten_numbers(shape.example))
        drift = size + len(self.free_parameters())
        matrix = covariance.unpack_matrix(memory[drift:])
        return FilterMemory(shape.rebuild(memory[:size]), tuple(memory[size:drift]), matrix)

    def list_estimates(self, xp: Namespace, forecast: Forecast, nis: Scalar) -> tuple[Column, Column]:
        """Return the estimates and the flat memory."""
        state, mean, matrix = forecast
        hidden, count = len(hidden_states.list_names(self.model)), self.unknowns()
        drift = mean[hidden:count]
        deviations = [xp.sqrt(matrix[i][i]) for i in range(len(mean))]
        free, values = list(zip(self.free_parameters(), drift, strict=True)), self._model_values()
        estimates = [*mean[:hidden], *(one.values(xp, values, x)[0][1] for one, x in free), *mean[count:]]
        sizes = [*[1.0] * hidden, *(one.size(xp, values, x) for one, x in free), *[1.0] * len(mean[count:])]
        estimates += [x * s for x, s in zip(deviations, sizes, strict=True)]
        for i, j in combinations(range(count), 2):
            both = deviations[i] * deviations[j]
            some = both > 0.0
            estimates.append(xp.where(some, matrix[i][j] / xp.where(some, both, 1.0), 0.0))
        unknowns = [row[:count] for row in matrix[:count]]
        memory = [*flatten_numbers(state), *drift, *covariance.pack_matrix(unknowns)]
        return [*estimates, nis], memory


def _find_deviation(output: Output) -> Output:
    unit = of_reading(DIFFERENCE, output.unit)
    return Output(unit, f"standard deviation of {output.long_name}", f"s_{output.symbol}")
