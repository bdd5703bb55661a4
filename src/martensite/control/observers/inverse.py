"""Inverse model: the fraction at which the model has the measured resistance.

    T from the heat balance of the model,     R(ξ, ε(ξ, T), T) = reading  →  ξ,     y = y(ξ, T)

Strain and force are in equilibrium with the mechanism. The root is bracketed between austenite and martensite; a
reading beyond both gives the nearer phase, and an old reading (age above 0) leaves the model as it is. With a time
constant τ above 0 the fraction moves from the model towards the root by dt/(τ + dt): noise has less effect, errors of
the model more.

Where R is nearly flat in ξ the problem is ill-posed: a relative noise ρ of the resistance causes an error of ρ/|s| in
ξ, with the estimate `sensitivity`, s = d ln R/dξ. Where R has an extremum between the phases, there are two roots, and
one of them is returned.
"""

from typing import Any

from martensite.actuators.assembly import advance_steps
from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param, text
from martensite.control.observers import hidden_states
from martensite.control.observers.base import (
    OBSERVERS,
    AbstractObserver,
    Column,
    Named,
    list_required,
    list_several,
    require_outputs,
)
from martensite.kernels.bracketed_newton import solve_bracketed
from martensite.kernels.dual import value_and_slope
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers

ITERATIONS = 8
FLAT = 1e-6
"""Relative difference of the resistances of both phases below which the equation is not solved."""
BEYOND = 0.01
"""Extension of the bracket beyond the phases, so that a root at its end is exact."""


@OBSERVERS.register("inverse-model")
class InverseModel(AbstractObserver):
    """Fraction from the resistance by inversion of the model."""

    measured: str = text("reading of the resistance", default="resistance")
    wanted: tuple[str, ...] = text("estimated outputs; default: states, coordinates, strain, reading", default=())
    lag: Number = param("s", "time constant τ", low=0.0, default=0.0)

    def check(self) -> None:
        require_outputs(self, (self.measured, *list_several(self.wanted)))
        self.__dict__["_example"] = hidden_states.build_example(self.model)
        if len(self.model.actuators()) != 1:
            raise ParameterError(
                f"Observer `inverse-model` is for one element, but its model has "
                f"{len(self.model.actuators())}; take a Kalman filter."
            )

    def reads(self) -> tuple[str, ...]:
        return (self.measured,)

    def estimates(self) -> dict[str, Output]:
        outputs = self.model.outputs()
        return {name: outputs[name] for name in self._shown_outputs()} | {
            "sensitivity": Output("1", "change of ln R with the fraction", "s")
        }

    def _shown_outputs(self) -> list[str]:
        (port,) = self.model.actuators()
        own = (*hidden_states.list_names(self.model), *self.model.mechanism.outputs())
        chosen = list_several(self.wanted) or (*own, self.model.label(port, "strain"), self.measured)
        return list(dict.fromkeys(chosen))

    def rest(self, xp: Namespace, readings: Named, signals: Named) -> tuple[Column, Column]:
        applied = list_required(self, signals)
        return self._list_estimates(xp, self.model.init(xp, *applied), applied)

    def update(
        self, xp: Namespace, memory: Column, readings: Named, signals: Named, dt: Scalar, turns: int
    ) -> tuple[Column, Column]:
        applied = list_required(self, signals)
        before = NestedShape(self.__dict__["_example"]).rebuild(memory)
        state, _ = advance_steps(xp, self.model, before, [(applied, dt / turns)], turns)
        temperature, expected = hidden_states.read_hidden(xp, self.model, state, applied)

        def ohms(xp: Namespace, fraction: Scalar) -> Scalar:
            return self._ohms(xp, state, (temperature, fraction), applied)

        first, last = ohms(xp, 0.0), ohms(xp, 1.0)
        span = last - first
        flat = xp.abs(span) <= FLAT * xp.abs(first)
        per = xp.where(flat, 0.0, 1.0 / xp.where(flat, 1.0, span))
        wanted = xp.clip((readings[self.measured] - first) * per, 0.0, 1.0)

        def beyond(xp: Namespace, fraction: Scalar) -> Scalar:
            return xp.where(flat, fraction - expected, (ohms(xp, fraction) - first) * per - wanted)

        bracket = -BEYOND, 1.0 + BEYOND
        root = solve_bracketed(xp, beyond, wanted, bracket, ITERATIONS)
        fresh = readings[f"{self.measured}.age"] <= 1e-9 * dt
        gain = xp.where(fresh, dt / (self.lag + dt), 0.0)
        fraction = xp.clip(expected + gain * (root - expected), 0.0, 1.0)
        there = hidden_states.place_hidden(xp, self.model, state, (temperature, fraction), applied)
        return self._list_estimates(xp, there, applied)

    def _ohms(self, xp: Namespace, state: Any, at: Column, signals: Column) -> Scalar:
        there = hidden_states.place_hidden(xp, self.model, state, at, signals)
        return hidden_states.observe_model(xp, self.model, there, signals)[self.measured]

    def _list_estimates(self, xp: Namespace, state: Any, signals: Column) -> tuple[Column, Column]:
        outputs = hidden_states.observe_model(xp, self.model, state, signals)
        temperature, fraction = (outputs[name] for name in hidden_states.list_names(self.model))

        def ohms(xp: Namespace, fraction: Scalar) -> Scalar:
            return self._ohms(xp, state, (temperature, fraction), signals)

        value, slope = value_and_slope(xp, ohms, fraction)
        estimates = [*(outputs[name] for name in self._shown_outputs()), slope / value]
        return estimates, flatten_numbers(state)
