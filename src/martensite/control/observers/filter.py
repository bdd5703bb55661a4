"""What Kalman filters have in common: temperature and fraction of a model, and how sure they are.

    x = (T, ξ) at every port, and factors of parameters that drift;      P = cov(x)
    x⁻ = f(x) over a period under the signals applied,   + noise of variance Q T
    y = h(x⁻): outputs of the model;  those named in `measured` are compared with readings

f is the model's own step and h its own `observe`: there is no second physics. Readings correct x
and everything else in proportion to how it is correlated with them (`covariance`); a fraction that
would leave [0, 1] is put at the end of it, and the rest follows. The whole state of the model
goes along and keeps its history (`hidden`). A reading that is older than `oldest` is not used.

The noise of a reading has the variance (ρ h)² + σ², with its share ρ and its deviation σ in SI.
Drifting parameters are estimated as factors of the model's values, as random walks.

Source: Bar-Shalom, Li and Kirubarajan (2001), sections 5.2 and 10.3. Sizes of the noise are
assumed; whether they fit is what `martensite_control.consistency` is for.

Estimates are: what is hidden, drifting parameters, outputs named in `wanted` (coordinates, strain
and readings by default), each with its standard deviation `NAME_std`, correlations among the
first, and the normalised innovation squared `nis`, 0 without a reading.
"""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, NamedTuple

from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import param, text
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

LEAST, MOST = 0.2, 5.0
"""Limits of the factors of drifting parameters."""
HAIR = 1e-9
"""Part of a period that is rounding."""
CORRELATION = "correlation"


class Believed(NamedTuple):
    """What a filter remembers."""

    state: Any
    """Of the model."""
    drift: tuple[Scalar, ...]
    covariance: Matrix


class Forecast(NamedTuple):
    """What is expected before the readings of a sample."""

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
    reading_noise: Scalar = param("1", "standard deviation of readings as a share of them", low=0.0, default=0.01)
    reading_deviation: Scalar = param(
        DIFFERENCE, "standard deviation of readings whatever they are; in SI if units differ", low=0.0, default=0.0
    )
    temperature_noise: Scalar = param("K/s^0.5", "random walk of the temperature", low=0.0, default=0.5)
    fraction_noise: Scalar = param("1/s^0.5", "random walk of the martensite fraction", low=0.0, default=0.02)
    drift_noise: Scalar = param("1/s^0.5", "random walk of drifting parameters, as a share", low=0.0, default=1e-3)
    first_temperature: Scalar = param(DEGREES, "standard deviation of temperature at the start", low=0.0, default=1.0)
    first_fraction: Scalar = param("1", "standard deviation of the fraction at the start", low=0.0, default=0.02)
    first_drift: Scalar = param(
        "1", "standard deviation of drifting parameters at the start, as a share of them", low=0.0, default=0.02
    )
    oldest: Scalar = param("s", "age up to which a reading is used", low=0.0, default=0.0)

    def check(self) -> None:
        """Raise `ParameterError` unless the model can be gone along with and all names are its."""
        known = list(self.model.outputs())
        for name in (*self.reads(), *list_several(self.wanted)):
            if name not in known:
                raise ParameterError(
                    f"Observer `{self.registered_name}`: its model has no output `{name}`. {suggest_name(name, known)}"
                )
        for path in self._paths():
            if self.model.value_of(path) == 0.0:
                raise ParameterError(f"Parameter `{path}` cannot drift: it is 0, and drifts by a factor.")
        self.__dict__["_example"] = hidden_states.build_example(self.model)

    def reads(self) -> tuple[str, ...]:
        """Readings that it uses."""
        return list_several(self.measured)

    def shown_outputs(self) -> list[str]:
        """Outputs of the model that are estimated beside what is hidden."""
        own = [self.model.label(port, "strain") for port in self.model.actuators()]
        chosen = list_several(self.wanted) or (*self.model.mechanism.outputs(), *own)
        unknown = hidden_states.list_names(self.model)
        return [name for name in dict.fromkeys((*chosen, *self.reads())) if name not in unknown]

    def estimates(self) -> dict[str, Output]:
        """Values, standard deviations, correlations, and the NIS."""
        known = self.model.outputs()
        leaves = {leaf.path: leaf.declared for leaf in self.model.leaves()}
        found = {name: known[name] for name in hidden_states.list_names(self.model)}
        found |= {p: Output(leaves[p].unit, leaves[p].doc, p) for p in self._paths()}
        core = list(found)
        found |= {name: known[name] for name in self.shown_outputs()}
        found |= {f"{name}_std": _find_deviation(output) for name, output in list(found.items())}
        for a, b in _list_pairs(core):
            found[f"{CORRELATION}.{a}.{b}"] = Output("1", f"correlation of {a} and {b}", "ρ")
        return found | {"nis": Output("1", "normalised innovation squared", "NIS")}

    def _paths(self) -> list[str]:
        return [self.model.resolve(name) for name in list_several(self.drifting)]

    @abstractmethod
    def forecast(self, xp: Namespace, before: Believed, going: ObserverPeriod) -> Forecast:
        """What is expected a period later."""

    def rest(self, xp: Namespace, readings: Named, signals: Named) -> tuple[Column, Column]:
        """The model at rest under the signals, as sure as the first deviations say."""
        applied = list_required(self, signals)
        state = self.model.init(xp, *applied)
        drift = (1.0,) * len(self._paths())
        first = [self.first_temperature, self.first_fraction] * len(self.model.actuators())
        first += [self.first_drift] * len(drift)
        matrix = covariance.build_diagonal([x * x for x in first])
        mean, slopes = self.outlook(xp, state, drift, applied)
        return self._list_estimates(xp, Forecast(state, mean, covariance.propagate_covariance(slopes, matrix)), 0.0)

    def update(
        self, xp: Namespace, memory: Column, readings: Named, signals: Named, dt: Scalar, turns: int
    ) -> tuple[Column, Column]:
        """Estimates after the readings of this sample, and what is believed."""
        going = ObserverPeriod(list_required(self, signals), dt, turns)
        expected = self.forecast(xp, self._unflatten_memory(memory), going)
        rows = self._readings(xp, expected.mean, readings, dt)
        mean, matrix, nis = covariance.condition_on_readings(xp, expected.mean, expected.covariance, rows)
        for i in range(1, 2 * len(self.model.actuators()), 2):
            mean = covariance.put_unknown(xp, mean, matrix, i, xp.clip(mean[i], 0.0, 1.0))
        unknown, count = len(hidden_states.list_names(self.model)), self.unknowns()
        mean[unknown:count] = [xp.clip(x, LEAST, MOST) for x in mean[unknown:count]]
        model = self.model_at_factors(mean[unknown:count])
        at = mean[:unknown]
        state = hidden_states.place_hidden(xp, model, expected.state, at, going.signals)
        return self._list_estimates(xp, Forecast(state, mean, matrix), nis)

    def _readings(self, xp: Namespace, mean: Sequence[Scalar], readings: Named, dt: Scalar) -> list[UnknownReading]:
        names, found = self._rows(), list[UnknownReading]()
        for name in self.reads():
            i = names.index(name)
            size, age = self.reading_noise * mean[i], readings[f"{name}.age"]
            variance = size * size + self.reading_deviation * self.reading_deviation
            fresh = xp.where(age <= self.oldest + HAIR * dt, 1.0, 0.0)
            found.append(UnknownReading(i, readings[name], variance, fresh))
        return found

    def _rows(self) -> list[str]:
        return [*hidden_states.list_names(self.model), *self._paths(), *self.shown_outputs()]

    def unknowns(self) -> int:
        """Number of hidden values and of drifting parameters."""
        return len(hidden_states.list_names(self.model)) + len(self._paths())

    def model_at_factors(self, drift: Sequence[Scalar]) -> Any:
        """The model with drifting parameters at factors of their values."""
        pairs = zip(self._paths(), drift, strict=True)
        return self.model.rebuilt({path: x * self.model.value_of(path) for path, x in pairs})

    def read_model(self, xp: Namespace, state: Any, drift: Sequence[Scalar], signals: Column) -> list[Scalar]:
        """Hidden values, factors and outputs of a state."""
        found = hidden_states.observe_model(xp, self.model_at_factors(drift), state, signals)
        unknown = [found[name] for name in hidden_states.list_names(self.model)]
        return [*unknown, *drift, *(found[name] for name in self.shown_outputs())]

    def outlook(
        self, xp: Namespace, state: Any, drift: Sequence[Scalar], signals: Column
    ) -> tuple[list[Scalar], Matrix]:
        """The same, and its slopes with respect to hidden values and factors."""
        at = hidden_states.read_hidden(xp, self.model_at_factors(drift), state, signals)
        count = len(at)

        def from_unknowns(xp: Namespace, x: Sequence[Scalar]) -> Sequence[Scalar]:
            model = self.model_at_factors(x[count:])
            there = hidden_states.place_hidden(xp, model, state, x[:count], signals)
            return [*x, *self.read_model(xp, there, x[count:], signals)[len(x) :]]

        return compute_jacobian(xp, from_unknowns, [*at, *drift])

    def noise_covariance(self, xp: Namespace, state: Any, drift: Sequence[Scalar], going: ObserverPeriod) -> Matrix:
        """Covariance that the noise of a period adds to everything."""
        walks = [self.temperature_noise, self.fraction_noise] * len(self.model.actuators())
        walks += [self.drift_noise] * len(drift)
        _, slopes = self.outlook(xp, state, drift, going.signals)
        return covariance.propagate_covariance(slopes, covariance.build_diagonal([w * w * going.dt for w in walks]))

    def _unflatten_memory(self, memory: Column) -> Believed:
        shape = NestedShape(self.__dict__["_example"])
        size = len(flatten_numbers(shape.example))
        drift = size + len(self._paths())
        matrix = covariance.unpack_matrix(memory[drift:])
        return Believed(shape.rebuild(memory[:size]), tuple(memory[size:drift]), matrix)

    def _list_estimates(self, xp: Namespace, found: Forecast, nis: Scalar) -> tuple[Column, Column]:
        state, mean, matrix = found
        unknown, count = len(hidden_states.list_names(self.model)), self.unknowns()
        drift = mean[unknown:count]
        sizes = [self.model.value_of(path) for path in self._paths()]
        scale = [*[1.0] * unknown, *sizes, *[1.0] * len(self.shown_outputs())]
        deviations = [xp.sqrt(matrix[i][i]) for i in range(len(mean))]
        estimates = [x * s for x, s in zip(mean, scale, strict=True)]
        estimates += [x * xp.abs(s) for x, s in zip(deviations, scale, strict=True)]
        for i, j in _list_pairs(range(count)):
            both = deviations[i] * deviations[j]
            some = both > 0.0
            estimates.append(xp.where(some, matrix[i][j] / xp.where(some, both, 1.0), 0.0))
        left = [row[:count] for row in matrix[:count]]
        memory = [*flatten_numbers(state), *drift, *covariance.pack_matrix(left)]
        return [*estimates, nis], memory


def _list_pairs(items: Sequence[Any]) -> list[tuple[Any, Any]]:
    return [(a, b) for i, a in enumerate(items) for b in items[i + 1 :]]


def _find_deviation(output: Output) -> Output:
    unit = of_reading(DIFFERENCE, output.unit)
    return Output(unit, f"standard deviation of {output.long_name}", f"s_{output.symbol}")
