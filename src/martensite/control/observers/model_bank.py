"""Bank of models: a Kalman filter for each model on the same readings, with probabilities of the models.

    c_j = Σ_i π_ij μ_i                                           before the readings
    x_0j = Σ_i w_ij x_i,  w_ij = π_ij μ_i/c_j                    start of filter j (interaction)
    μ_j ∝ c_j Λ_j,  ln Λ_j = -½ Σ (ν²/S + ln S)                  after the readings
    x = Σ μ_j x_j,  P = Σ μ_j [P_j + (x_j - x)(x_j - x)ᵀ]        estimates

The first model is the nominal one. It holds for a mean time `sound`, then changes to one of the others, which holds for
`fault` and changes back: without evidence the first model is by far the most probable, and every model can return. The
estimates of the filters are mixed, and memories of equal mechanisms; each law keeps its history.

All models may be wrong. `confidence` is 1 if the innovations of the first model, started from the mixture, pass their
test (`innovation_test`), the standard deviation of the controlled estimate, including the spread of the models, is
small against its reach, and probabilities are steady. It is 0 at twice the bound of any of these. It falls at once, and
returns with readings, in `regain` at the earliest.

Source: Bar-Shalom, Li and Kirubarajan (2001), section 11.6: static and interacting multiple models.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

from martensite.actuators.assembly import AbstractSystem, Members
from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Number, param, part, text
from martensite.control.observers import covariance, hidden_states
from martensite.control.observers.base import OBSERVERS, Column, Named, ObserverPeriod, list_required, list_several
from martensite.control.observers.covariance import Matrix, UnknownReading
from martensite.control.observers.extended import ExtendedKalman
from martensite.control.observers.filter import AbstractFilter, FilterMemory, Forecast
from martensite.control.observers.innovation_test import RunningTest, find_misfit
from martensite.control.observers.usual_models import (
    AS_MODELLED,
    FAN,
    USUAL,
    UsualSizes,
    find_wrapped_path,
    list_usual_models,
)
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, find_largest, flatten_numbers, sum_column

Memories: TypeAlias = tuple[tuple[Scalar, ...], ...]
CONFIDENCE, MISFIT, MOST_PROBABLE, PROBABILITY = "confidence", "misfit", "most_probable", "probability_"


class Models(Members[AbstractSystem], init=False):
    """Systems by user-defined names."""

    noun, kind = "model", AbstractSystem


class BankMemory(NamedTuple):
    """Memory of a bank."""

    weights: tuple[Scalar, ...]
    tests: tuple[RunningTest, ...]
    """Tests of the innovations of every reading."""
    usual_weights: tuple[Scalar, ...]
    """Running mean of the probabilities."""
    confidence: Scalar
    reach: Scalar
    """Difference of the controlled output between austenite and martensite."""
    filters: Memories


class FilterUpdate(NamedTuple):
    """A filter before and after readings."""

    prior: Forecast
    rows: list[UnknownReading]
    posterior: Forecast
    likelihood: Scalar


@OBSERVERS.register("model-bank")
class ModelBank(ExtendedKalman):
    """Extended Kalman filters of several models, weighted by their likelihood."""

    cites = ("barshalom2001",)

    temperature_noise: Number = param("K/s^0.5", "random walk of the temperature", low=0.0, default=0.1)
    fraction_noise: Number = param("1/s^0.5", "random walk of the martensite fraction", low=0.0, default=0.003)
    models: Models = part("further models by name; default: the models of `usual`", default=Models())
    usual: tuple[str, ...] = text(f"predefined further models, of {', '.join(USUAL)}", default=USUAL, typical=FAN)
    fan_factor: Number = param("1", "film coefficient of `fan` over that of the model", above=0.0, default=2.5)
    rphase_rise: Number = param(
        "1", "relative rise of the resistance in R-phase, of `r_phase`", low=-0.5, high=1.0, default=0.15
    )
    slack_strain: Number = param("1", "lost fraction of the length, of `slack`", above=0.0, default=0.015)
    sound: Number = param("s", "mean time for which the first model holds", above=0.0, default=1e5)
    fault: Number = param("s", "mean time for which another model then holds", above=0.0, default=60.0)
    window: Number = param("s", "time over which innovations are averaged", above=0.0, default=0.5)
    bound: Number = param("1", "chi-square above which innovations do not fit", above=0.0, default=30.0)
    controlled: str = text("estimate whose spread counts; by default the first of the mechanism", default="")
    spread: Number = param(
        "1", "standard deviation over reach of this estimate above which confidence is lost", above=0.0, default=0.1
    )
    change: Number = param("1", "change of probabilities above which confidence is lost", above=0.0, default=0.25)
    regain: Number = param("s", "time in which confidence returns", above=0.0, default=5.0)

    def check(self) -> None:
        super().check()
        for name in list_several(self.usual):
            if name not in USUAL:
                raise ParameterError(f"`usual` knows no model `{name}`. {suggest_name(name, USUAL)}")
        if self.controlled and self.controlled not in self._rows():
            raise ParameterError(
                f"`controlled` is `{self.controlled}`, which is not estimated. "
                f"{suggest_name(self.controlled, self._rows())}"
            )
        self.__dict__["_members"] = {name: self._check_member(name, m) for name, m in self._list_models(floats).items()}
        self.__dict__["_memory"] = self._build_example()

    def _check_member(self, name: str, model: AbstractSystem) -> ExtendedKalman:
        settings = {key: self.__dict__[key] for key in AbstractFilter.declarations}
        try:
            drifting = tuple(find_wrapped_path(self.model.resolve(path), model) for path in list_several(self.drifting))
            member = ExtendedKalman(**(settings | {"model": model, "drifting": drifting}))
        except ParameterError as error:
            raise ParameterError(f"Model `{name}` of a bank does not fit: {error}") from None
        drives, first = ([f"{one.name} [{one.unit}]" for one in m.drives()] for m in (model, self.model))
        if drives != first:
            raise ParameterError(
                f"Model `{name}` of a bank is driven by {', '.join(drives)}, not by {', '.join(first)}."
            )
        missing = [row for row in self.shown_outputs() if row not in member.shown_outputs()]
        if missing:
            raise ParameterError(f"Model `{name}` of a bank has no output `{missing[0]}`, which the first one has.")
        return member

    def _build_example(self) -> BankMemory:
        signals = {one.name: hidden_states.REST if one.unit == "K" else 0.0 for one in self.model.drives()}
        state = self.model.init(floats, *signals.values())
        outputs = hidden_states.observe_model(floats, self.model, state, list(signals.values()))
        return self._begin(floats, outputs | {f"{name}.age": 0.0 for name in self.reads()}, signals)[0]

    def _list_models(self, xp: Namespace) -> dict[str, AbstractSystem]:
        own = self.models.members()
        if own:
            return {AS_MODELLED: self.model, **own}
        sizes = UsualSizes(self.fan_factor, self.rphase_rise, self.slack_strain)
        return list_usual_models(xp, self.model, list_several(self.usual), sizes)

    def _filters(self, xp: Namespace) -> list[AbstractFilter]:
        """Return the filter of every model with its present parameters; the first is the bank itself."""
        members: Mapping[str, ExtendedKalman] = self.__dict__["_members"]
        settings = {key: self.__dict__[key] for key in AbstractFilter.declarations}
        models, filters = self._list_models(xp), list[AbstractFilter]()
        for name, one in members.items():
            extras = {key: value for key, value in one.__dict__.items() if key == "drifting" or key.startswith("_")}
            filters.append((one if filters else self).rebuilt({**settings, **extras, "model": models[name]}))
        return filters

    def estimates(self) -> dict[str, Output]:
        outputs = super().estimates()
        for name in self.__dict__["_members"]:
            outputs[PROBABILITY + name] = Output("1", f"probability of model {name}", "μ")
        outputs[MOST_PROBABLE] = Output("1", "index of the most probable model", "j")
        outputs[MISFIT] = Output("1", "test of the innovations over its bound", "m")
        return outputs | {CONFIDENCE: Output("1", "confidence in the estimates", "γ")}

    def rest(self, xp: Namespace, readings: Named, signals: Named) -> tuple[Column, Column]:
        memory, starts = self._begin(xp, readings, signals)
        return self._answer(xp, memory, starts, 0.0, 0.0, memory.filters)

    def _begin(self, xp: Namespace, readings: Named, signals: Named) -> tuple[BankMemory, list[Forecast]]:
        applied, filters = list_required(self, signals), self._filters(xp)
        memories = tuple(tuple(AbstractFilter.rest(one, xp, readings, signals)[1]) for one in filters)
        starts = list[Forecast]()
        for one, memory in zip(filters, memories, strict=True):
            state, drift, matrix = one.unflatten_memory(memory)
            mean, slopes = one.outlook(xp, state, drift, applied)
            starts.append(Forecast(state, mean, covariance.propagate_covariance(slopes, matrix)))
        others = len(filters) - 1
        probability = self.fault / (self.sound + self.fault) / max(others, 1)
        weights = (1.0 - probability * others, *(probability for _ in range(others)))
        tests = tuple(RunningTest() for _ in self.reads())
        reach = self._find_reach(xp, starts[0], filters[0], applied)
        return BankMemory(weights, tests, weights, 1.0, reach, memories), starts

    def _find_reach(self, xp: Namespace, start: Forecast, one: AbstractFilter, applied: Column) -> Scalar:
        """Return the difference of the controlled output between austenite and martensite."""
        at, row, count = start.mean, self._controlled_row(), len(hidden_states.list_names(self.model))
        ends: list[Scalar] = []
        for fraction in (0.0, 1.0):
            hidden = [fraction if k % 2 else x for k, x in enumerate(at[:count])]
            state = hidden_states.place_hidden(xp, one.model, start.state, hidden, applied)
            ends.append(one.read_model(xp, state, at[count : one.unknowns()], applied)[row])
        return xp.maximum(xp.abs(ends[1] - ends[0]), covariance.LEAST_VARIANCE)

    def _controlled_row(self) -> int:
        rows, first = self._rows(), next(iter(self.model.mechanism.outputs()), "")
        name = self.controlled or (first if first in rows else hidden_states.list_names(self.model)[1])
        return rows.index(name)

    def update(
        self, xp: Namespace, memory: Column, readings: Named, signals: Named, dt: Scalar, turns: int
    ) -> tuple[Column, Column]:
        before: BankMemory = NestedShape(self.__dict__["_memory"]).rebuild(memory)
        period, filters = ObserverPeriod(list_required(self, signals), dt, turns), self._filters(xp)
        ahead, shares = self._switch(xp, before.weights, dt)
        starts = self._interact(xp, filters, before, shares, period)
        rows = [self._weigh(xp, one, at, readings, period) for one, at in zip(filters, starts, strict=True)]
        best = find_largest(xp, [one.likelihood for one in rows])
        after = [c * xp.exp(one.likelihood - best) for c, one in zip(ahead, rows, strict=True)]
        whole = sum_column(after)
        weights = tuple(x / whole for x in after)
        weight = 1.0 - xp.exp(-dt / self.window)
        first = rows[0].prior
        innovations = [
            row._replace(value=row.value - first.mean[i], variance=first.covariance[i][i] + row.variance)
            for row in rows[0].rows
            for i in [row.index]
        ]
        tests = tuple(test.add(xp, one, weight) for test, one in zip(before.tests, innovations, strict=True))
        nis = sum_column([one.is_used * one.value * one.value / one.variance for one in innovations])
        memories = tuple(
            tuple(one.list_estimates(xp, row.posterior, 0.0)[1]) for one, row in zip(filters, rows, strict=True)
        )
        misfit = find_misfit(xp, tests, weight, self.bound)
        slow = 1.0 - xp.exp(-dt / self.regain)
        usual = tuple(m + slow * (x - m) for x, m in zip(weights, before.usual_weights, strict=True))
        fresh = find_largest(xp, [one.is_used for one in innovations])  # trust comes back by evidence only
        trust = before.confidence + fresh * dt / self.regain
        now = before._replace(usual_weights=usual, weights=weights, tests=tests, confidence=trust)
        return self._answer(xp, now, [one.posterior for one in rows], nis, misfit, memories)

    def _switch(self, xp: Namespace, weights: Column, dt: Scalar) -> tuple[list[Scalar], list[list[Scalar]]]:
        """Return the probabilities before the readings, and the mixing weights of every filter."""
        others = len(weights) - 1
        if not others:
            return [weights[0]], [[1.0]]
        leave, back = (1.0 - xp.exp(-dt / time) for time in (self.sound, self.fault))
        into = [[(1.0 - leave) * weights[0], *(back * x for x in weights[1:])]]
        for k in range(1, others + 1):
            row: list[Scalar] = [0.0] * (others + 1)
            row[0], row[k] = leave / others * weights[0], (1.0 - back) * weights[k]
            into.append(row)
        sums = [sum_column(row) for row in into]
        return sums, [[x / total for x in row] for row, total in zip(into, sums, strict=True)]

    def _interact(
        self, xp: Namespace, filters: list[AbstractFilter], before: BankMemory, shares: Matrix, period: ObserverPeriod
    ) -> list[FilterMemory]:
        """Return the mixed states from which the filters continue."""
        ends = [one.unflatten_memory(memory) for one, memory in zip(filters, before.filters, strict=True)]
        models = [one.model_at_factors(xp, end.drift) for one, end in zip(filters, ends, strict=True)]
        points = [
            [*hidden_states.read_hidden(xp, model, end.state, period.signals), *end.drift]
            for model, end in zip(models, ends, strict=True)
        ]
        count, mixed = len(points[0]) - len(ends[0].drift), list[FilterMemory]()
        for k, (one, end, column) in enumerate(zip(filters, ends, shares, strict=True)):
            chosen = [i for i in range(len(ends)) if k in (0, i) or i == 0]
            weights = [column[i] for i in chosen]
            mean, matrix = _mix_moments(weights, [points[i] for i in chosen], [ends[i].covariance for i in chosen])
            state = end.state._replace(mechanism=_mix_memories(weights, [ends[i].state.mechanism for i in chosen], end))
            model = one.model_at_factors(xp, mean[count:])
            state = hidden_states.place_hidden(xp, model, state, mean[:count], period.signals)
            mixed.append(FilterMemory(state, tuple(mean[count:]), matrix))
        return mixed

    def _weigh(
        self, xp: Namespace, one: AbstractFilter, start: FilterMemory, readings: Named, period: ObserverPeriod
    ) -> FilterUpdate:
        expected = one.forecast(xp, start, period)
        rows = one.pair_readings(xp, expected.mean, readings, period.dt)
        mean, matrix, weight = list(expected.mean), expected.covariance, 0.0
        for row in rows:
            variance = xp.maximum(matrix[row.index][row.index] + row.variance, covariance.LEAST_VARIANCE)
            short = row.value - mean[row.index]
            weight = weight - 0.5 * row.is_used * (short * short / variance + xp.log(variance))
            mean, matrix, _ = covariance.condition_on_readings(xp, mean, matrix, [row])
        return FilterUpdate(expected, rows, one.place_unknowns(xp, expected.state, mean, matrix, period), weight)

    def _answer(
        self, xp: Namespace, now: BankMemory, forecasts: list[Forecast], nis: Scalar, misfit: Scalar, memories: Memories
    ) -> tuple[Column, Column]:
        mean, matrix = _mix_moments(now.weights, [one.mean for one in forecasts], [one.covariance for one in forecasts])
        estimates, _ = self.list_estimates(xp, Forecast(forecasts[0].state, mean, matrix), nis)
        k = self._controlled_row()
        wide = xp.sqrt(matrix[k][k]) / (self.spread * now.reach)
        moved = 0.5 * sum_column([xp.abs(x - m) for x, m in zip(now.weights, now.usual_weights, strict=True)])
        doubt = find_largest(xp, [misfit, wide, moved / self.change])
        allowed = xp.clip(2.0 - doubt, 0.0, 1.0)
        confidence = xp.minimum(allowed, now.confidence)
        best, largest = 0.0, now.weights[0]
        for j, weight in enumerate(now.weights[1:], start=1):
            best, largest = xp.where(weight > largest, float(j), best), xp.maximum(weight, largest)
        memory = now._replace(confidence=confidence, filters=memories)
        return [*estimates, *now.weights, best, misfit, confidence], flatten_numbers(memory)


def _mix_moments(
    weights: Sequence[Scalar], means: Sequence[Sequence[Scalar]], matrices: Sequence[Matrix]
) -> tuple[list[Scalar], Matrix]:
    mean = [sum_column([w * x for w, x in zip(weights, column, strict=True)]) for column in zip(*means, strict=True)]
    below: list[Scalar] = []
    apart = [[x - m for x, m in zip(one, mean, strict=True)] for one in means]
    for i in range(len(mean)):
        for j in range(i + 1):
            rows = zip(weights, matrices, apart, strict=True)
            below.append(sum_column([w * (p[i][j] + d[i] * d[j]) for w, p, d in rows]))
    return mean, covariance.unpack_matrix(below)


def _mix_memories(weights: Sequence[Scalar], memories: Sequence[Any], own: FilterMemory) -> Any:
    """Return the memory of a mechanism: mixed if all have the same structure, else its own."""
    memory = own.state.mechanism
    flat = [flatten_numbers(one) for one in memories]
    if len({(type(one), len(numbers)) for one, numbers in zip(memories, flat, strict=True)}) > 1:
        return memory
    rows = zip(*flat, strict=True)
    return NestedShape(memory).rebuild([sum_column([w * x for w, x in zip(weights, row, strict=True)]) for row in rows])
