"""Common parts of Kalman filters: temperature and fraction of a model, and their covariance.

    x = (T, ξ) at every port, and factors of parameters that drift;      P = cov(x)
    x⁻ = f(x) over a period under the signals applied,   + noise of variance Q T
    y = h(x⁻): outputs of the model;  those named in `measured` are compared with readings

f is the step of the model and h its `observe`, so filter and plant share their physics. Readings correct x
and everything else in proportion to how it is correlated with them (`covariance`); a fraction that
would leave [0, 1] is put at the end of it, and the rest follows. The whole state of the model
goes along and keeps its history (`hidden`). A reading that is older than `oldest` is not used.

The noise of a reading has the variance (ρ h)² + σ², with its share ρ and its deviation σ in SI.
Drifting parameters are estimated as factors of the model's values, as random walks.

Source: Bar-Shalom, Li and Kirubarajan (2001), sections 5.2 and 10.3. Sizes of the noise are
assumed; whether they fit is what `martensite.control.loop.consistency` is for.

Estimates are: what is hidden, drifting parameters, outputs named in `wanted` (coordinates, strain
and readings by default), each with its standard deviation `NAME_std`, correlations among the
first, and the normalised innovation squared `nis`, 0 without a reading.
"""

from abc import abstractmethod
from collections.abc import Sequence
from itertools import combinations
from typing import Any, NamedTuple

from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import ParameterError, suggest_name
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
)
from martensite.control.observers.covariance import Matrix, UnknownReading
from martensite.kernels.dual import compute_jacobian
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers

LEAST_FACTOR, MOST_FACTOR = 0.2, 5.0
"""Limits of factors."""
FAR = 4.0
"""First deviations within which logarithms and offsets stay."""
PERIOD_TOLERANCE = 1e-9
"""Part of a period that is rounding."""
CORRELATION = "correlation"


class FreeParameter(NamedTuple):
    """A parameter of the model that a filter estimates, or several of one kind that move together."""

    paths: tuple[str, ...]
    scale: str
    """Meaning of the estimate: a `factor` f, v = v₀ f; a `logarithm` x, v = v₀ exp x; an `offset` x, v = v₀ + x."""
    first: Scalar
    """Standard deviation at the start, of f or x."""
    walk: Scalar
    """Density of its random walk [1/s^0.5]."""
    opposite: tuple[str, ...] = ()
    """Parameters that change by the opposite offset."""

    @property
    def path(self) -> str:
        """Return the path of the parameter that is shown."""
        return self.paths[0]

    @property
    def start(self) -> float:
        """Return the initial value of f or x."""
        return 1.0 if self.scale == "factor" else 0.0

    def limit(self, xp: Namespace, x: Scalar) -> Scalar:
        """Within what is possible."""
        if self.scale == "factor":
            return xp.clip(x, LEAST_FACTOR, MOST_FACTOR)
        far = FAR * self.first
        return xp.clip(x, -far, far)

    def values(self, xp: Namespace, known: Named, x: Scalar) -> list[tuple[str, Scalar]]:
        """Return all its parameters by path, of those of the model."""
        found = [(path, self._at(xp, known[path], x)) for path in self.paths]
        return found + [(path, known[path] - x) for path in self.opposite]

    def size(self, xp: Namespace, known: Named, x: Scalar) -> Scalar:
        """Return the derivative of the parameter with respect to f or x."""
        if self.scale == "offset":
            return 1.0
        value = known[self.path]
        return xp.abs(value if self.scale == "factor" else self._at(xp, value, x))

    def _at(self, xp: Namespace, value: Scalar, x: Scalar) -> Scalar:
        if self.scale == "offset":
            return value + x
        return x * value if self.scale == "factor" else value * xp.exp(x)


class Believed(NamedTuple):
    """Memory of a filter."""

    state: Any
    """State of the model."""
    drift: tuple[Scalar, ...]
    covariance: Matrix


class Forecast(NamedTuple):
    """Prediction before the readings of a sample."""

    state: Any
    mean: list[Scalar]
    """Hidden values, factors of parameters, then outputs."""
    covariance: Matrix


class AbstractFilter(AbstractObserver):
    """Interface of a Kalman filter; a subclass adds `forecast`."""

    names_reading = ("measured",)

    measured: tuple[str, ...] = text("readings it uses, called as the outputs of the model", default=("resistance",))
    wanted: tuple[str, ...] = text("outputs to be estimated; its own choice if none", default=())
    drifting: tuple[str, ...] = text("parameters of the model that it estimates", default=())
    reading_noise: Number = param("1", "standard deviation of readings as a share of them", low=0.0, default=0.01)
    reading_deviation: Number = param(
        DIFFERENCE, "standard deviation of readings whatever they are; in SI if units differ", low=0.0, default=0.0
    )
    temperature_noise: Number = param("K/s^0.5", "random walk of the temperature", low=0.0, default=0.5)
    fraction_noise: Number = param("1/s^0.5", "random walk of the martensite fraction", low=0.0, default=0.02)
    drift_noise: Number = param("1/s^0.5", "random walk of drifting parameters, as a share", low=0.0, default=1e-3)
    first_temperature: Number = param(DEGREES, "standard deviation of temperature at the start", low=0.0, default=1.0)
    first_fraction: Number = param("1", "standard deviation of the fraction at the start", low=0.0, default=0.02)
    first_drift: Number = param(
        "1", "standard deviation of drifting parameters at the start, as a share of them", low=0.0, default=0.02
    )
    oldest: Number = param("s", "age up to which a reading is used", low=0.0, default=0.0)

    def check(self) -> None:
        """Raise `ParameterError` unless the model can be gone along with and all names are its."""
        known = list(self.model.outputs())
        for name in (*self.reads(), *list_several(self.wanted)):
            if name not in known:
                raise ParameterError(
                    f"Observer `{self.registered_name}`: its model has no output `{name}`. {suggest_name(name, known)}"
                )
        self.__dict__["_example"] = hidden_states.build_example(self.model)
        for one in self.free_parameters():
            if one.scale != "offset" and self.model.value_of(one.path) == 0.0:
                raise ParameterError(f"Parameter `{one.path}` cannot drift: it is 0, and drifts by a factor.")

    def reads(self) -> tuple[str, ...]:
        """Return the readings that it uses."""
        return list_several(self.measured)

    def shown_outputs(self) -> list[str]:
        """Return the outputs of the model that are estimated beside what is hidden."""
        own = [self.model.label(port, "strain") for port in self.model.actuators()]
        chosen = list_several(self.wanted) or (*self.model.mechanism.outputs(), *own)
        unknown = hidden_states.list_names(self.model)
        return [name for name in dict.fromkeys((*chosen, *self.reads())) if name not in unknown]

    def estimates(self) -> dict[str, Output]:
        """Return the values, standard deviations, correlations, and the NIS."""
        known = self.model.outputs()
        leaves = {leaf.path: leaf.declared for leaf in self.model.leaves()}
        found = {name: known[name] for name in hidden_states.list_names(self.model)}
        free = [one.path for one in self.free_parameters()]
        found |= {p: Output(leaves[p].unit, leaves[p].doc, p) for p in free}
        core = list(found)
        found |= {name: known[name] for name in self.shown_outputs()}
        found |= {f"{name}_std": _find_deviation(output) for name, output in list(found.items())}
        for a, b in combinations(core, 2):
            found[f"{CORRELATION}.{a}.{b}"] = Output("1", f"correlation of {a} and {b}", "ρ")
        return found | {"nis": Output("1", "normalised innovation squared", "NIS")}

    def free_parameters(self) -> list[FreeParameter]:
        """Return the parameters of the model that it estimates: those that drift, by factors."""
        paths = [self.model.resolve(name) for name in list_several(self.drifting)]
        return [FreeParameter((path,), "factor", self.first_drift, self.drift_noise) for path in paths]

    @abstractmethod
    def forecast(self, xp: Namespace, before: Believed, going: ObserverPeriod) -> Forecast:
        """Predict the state a period later."""

    def rest(self, xp: Namespace, readings: Named, signals: Named) -> tuple[Column, Column]:
        """Return the model at rest under the signals, as sure as the first deviations say."""
        return self.list_estimates(xp, self.first_forecast(xp, list_required(self, signals)), 0.0)

    def first_forecast(self, xp: Namespace, signals: Column) -> Forecast:
        """Predict the state at rest."""
        state = self.model.init(xp, *signals)
        drift = tuple(one.start for one in self.free_parameters())
        matrix = self.first_covariance(xp, [x * x for x in self.first_deviations()], signals)
        mean, slopes = self.outlook(xp, state, drift, signals)
        return Forecast(state, mean, covariance.propagate_covariance(slopes, matrix))

    def first_deviations(self) -> list[Scalar]:
        """Return the standard deviations of all unknowns at the start."""
        own = [self.first_temperature, self.first_fraction] * len(self.model.actuators())
        return [*own, *(one.first for one in self.free_parameters())]

    def first_covariance(self, xp: Namespace, variances: Sequence[Scalar], signals: Column) -> Matrix:
        """Return the covariance of the unknowns at rest: none depends on another."""
        return covariance.build_diagonal(variances)

    def update(
        self, xp: Namespace, memory: Column, readings: Named, signals: Named, dt: Scalar, turns: int
    ) -> tuple[Column, Column]:
        """Return the estimates after the readings of this sample, and what is believed."""
        going = ObserverPeriod(list_required(self, signals), dt, turns)
        expected = self.forecast(xp, self.unflatten_memory(memory), going)
        rows = self.pair_readings(xp, expected.mean, readings, dt)
        mean, matrix, nis = covariance.condition_on_readings(xp, expected.mean, expected.covariance, rows)
        return self.list_estimates(xp, self.place_unknowns(xp, expected.state, mean, matrix, going), nis)

    def place_unknowns(
        self, xp: Namespace, state: Any, mean: list[Scalar], matrix: Matrix, going: ObserverPeriod
    ) -> Forecast:
        """Return the unknowns within their limits, and the state put there."""
        for i in range(1, 2 * len(self.model.actuators()), 2):
            mean = covariance.put_unknown(xp, mean, matrix, i, xp.clip(mean[i], 0.0, 1.0))
        unknown, count = len(hidden_states.list_names(self.model)), self.unknowns()
        mean[unknown:count] = self.limit_factors(xp, mean[unknown:count])
        model = self.model_at_factors(xp, mean[unknown:count])
        there = hidden_states.place_hidden(xp, model, state, mean[:unknown], going.signals)
        return Forecast(there, mean, matrix)

    def pair_readings(self, xp: Namespace, mean: Sequence[Scalar], readings: Named, dt: Scalar) -> list[UnknownReading]:
        """Return the readings with what is expected of them."""
        names, found = self._rows(), list[UnknownReading]()
        for name in self.reads():
            i = names.index(name)
            size, age = self.reading_noise * mean[i], readings[f"{name}.age"]
            variance = size * size + self.reading_deviation * self.reading_deviation
            fresh = xp.where(age <= self.oldest + PERIOD_TOLERANCE * dt, 1.0, 0.0)
            found.append(UnknownReading(i, readings[name], variance, fresh))
        return found

    def _rows(self) -> list[str]:
        free = [one.path for one in self.free_parameters()]
        return [*hidden_states.list_names(self.model), *free, *self.shown_outputs()]

    def unknowns(self) -> int:
        """Return the number of hidden values and of drifting parameters."""
        return len(hidden_states.list_names(self.model)) + len(self.free_parameters())

    def model_at_factors(self, xp: Namespace, drift: Sequence[Scalar]) -> Any:
        """Return the model with its free parameters at what is estimated of them."""
        rows = zip(self.free_parameters(), drift, strict=True)
        known = self._model_values()
        return self.model.rebuilt({path: value for one, x in rows for path, value in one.values(xp, known, x)})

    def _model_values(self) -> dict[str, Scalar]:
        return {leaf.path: leaf.value for leaf in self.model.leaves()}

    def limit_factors(self, xp: Namespace, drift: Sequence[Scalar]) -> list[Scalar]:
        """Return the estimates of free parameters within their limits."""
        return [one.limit(xp, x) for one, x in zip(self.free_parameters(), drift, strict=True)]

    def read_model(self, xp: Namespace, state: Any, drift: Sequence[Scalar], signals: Column) -> list[Scalar]:
        """Return the hidden values, factors and outputs of a state."""
        found = hidden_states.observe_model(xp, self.model_at_factors(xp, drift), state, signals)
        unknown = [found[name] for name in hidden_states.list_names(self.model)]
        return [*unknown, *drift, *(found[name] for name in self.shown_outputs())]

    def outlook(
        self, xp: Namespace, state: Any, drift: Sequence[Scalar], signals: Column
    ) -> tuple[list[Scalar], Matrix]:
        """Return the outlook and its slopes with respect to hidden values and factors."""
        at = hidden_states.read_hidden(xp, self.model_at_factors(xp, drift), state, signals)
        count = len(at)

        def from_unknowns(xp: Namespace, x: Sequence[Scalar]) -> Sequence[Scalar]:
            model = self.model_at_factors(xp, x[count:])
            there = hidden_states.place_hidden(xp, model, state, x[:count], signals)
            return [*x, *self.read_model(xp, there, x[count:], signals)[len(x) :]]

        return compute_jacobian(xp, from_unknowns, [*at, *drift])

    def noise_covariance(self, xp: Namespace, state: Any, drift: Sequence[Scalar], going: ObserverPeriod) -> Matrix:
        """Return the covariance that the noise of a period adds to everything."""
        mean, slopes = self.outlook(xp, state, drift, going.signals)
        walks = [*self.hidden_walks(xp, mean), *(going.learning * one.walk for one in self.free_parameters())]
        return covariance.propagate_covariance(slopes, covariance.build_diagonal([w * w * going.dt for w in walks]))

    def hidden_walks(self, xp: Namespace, at: Sequence[Scalar]) -> list[Scalar]:
        """Return the densities of the random walks of temperature and fraction at every port, where these are."""
        return [self.temperature_noise, self.fraction_noise] * len(self.model.actuators())

    def unflatten_memory(self, memory: Column) -> Believed:
        """Return the memory by name, from its numbers."""
        shape = NestedShape(self.__dict__["_example"])
        size = len(flatten_numbers(shape.example))
        drift = size + len(self.free_parameters())
        matrix = covariance.unpack_matrix(memory[drift:])
        return Believed(shape.rebuild(memory[:size]), tuple(memory[size:drift]), matrix)

    def list_estimates(self, xp: Namespace, found: Forecast, nis: Scalar) -> tuple[Column, Column]:
        """Return the estimates, and the numbers of what is believed."""
        state, mean, matrix = found
        unknown, count = len(hidden_states.list_names(self.model)), self.unknowns()
        drift = mean[unknown:count]
        deviations = [xp.sqrt(matrix[i][i]) for i in range(len(mean))]
        free, known = list(zip(self.free_parameters(), drift, strict=True)), self._model_values()
        estimates = [*mean[:unknown], *(one.values(xp, known, x)[0][1] for one, x in free), *mean[count:]]
        sizes = [*[1.0] * unknown, *(one.size(xp, known, x) for one, x in free), *[1.0] * len(mean[count:])]
        estimates += [x * s for x, s in zip(deviations, sizes, strict=True)]
        for i, j in combinations(range(count), 2):
            both = deviations[i] * deviations[j]
            some = both > 0.0
            estimates.append(xp.where(some, matrix[i][j] / xp.where(some, both, 1.0), 0.0))
        left = [row[:count] for row in matrix[:count]]
        memory = [*flatten_numbers(state), *drift, *covariance.pack_matrix(left)]
        return [*estimates, nis], memory


def _find_deviation(output: Output) -> Output:
    unit = of_reading(DIFFERENCE, output.unit)
    return Output(unit, f"standard deviation of {output.long_name}", f"s_{output.symbol}")
