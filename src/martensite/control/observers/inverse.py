"""Inverse model: the fraction at which the model has the resistance that was read.

    T from the heat balance of the model,     R(ξ, ε(ξ, T), T) = reading  →  ξ,     y = y(ξ, T)

Strain and force follow ξ as they do in equilibrium with the mechanism. The root is bracketed between austenite and
martensite; a reading beyond the resistances of both gives the nearer one, and an old reading (age above 0) gives what
the model says. With a time constant τ above 0 the fraction goes from what the model says towards the root by dt/(τ +
dt): noise of readings passes less, errors of the model more.

Where R is nearly flat in ξ the problem is ill-posed: noise of a share ρ of the resistance makes
an error of ρ/|s| in ξ, with the `sensitivity` s = d ln R/dξ, which is among the estimates. Where R
rises and falls between the phases there are two roots, of which one is found.
"""

from typing import Any

from martensite.actuators.assembly import advance_steps
from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Number, param, text
from martensite.control.observers import hidden_states
from martensite.control.observers.base import OBSERVERS, AbstractObserver, Column, Named, list_required, list_several
from martensite.kernels.bracketed_newton import solve_bracketed
from martensite.kernels.dual import value_and_slope
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers

ITERATIONS = 8
FLAT = 1e-6
"""Difference of the resistances of both phases, as a share, below which nothing is solved."""
BEYOND = 0.01
"""Fraction by which the bracket reaches beyond the phases, so that a root there is hit exactly."""


@OBSERVERS.register("inverse-model")
class InverseModel(AbstractObserver):
    """Fraction from the resistance, by solving the model for it."""

    measured: str = text("reading of the resistance", default="resistance")
    wanted: tuple[str, ...] = text("outputs to be estimated; its own choice if none", default=())
    lag: Number = param("s", "time constant τ", low=0.0, default=0.0)

    def check(self) -> None:
        """Raise `ParameterError` unless the model has one element and a resistance."""
        known = list(self.model.outputs())
        for name in (self.measured, *list_several(self.wanted)):
            if name not in known:
                raise ParameterError(
                    f"Observer `inverse-model`: its model has no output `{name}`. {suggest_name(name, known)}"
                )
        self.__dict__["_example"] = hidden_states.build_example(self.model)
        if len(self.model.actuators()) != 1:
            raise ParameterError(
                f"Observer `inverse-model` is for one element, but its model has "
                f"{len(self.model.actuators())}; take a Kalman filter."
            )

    def reads(self) -> tuple[str, ...]:
        """Return the resistance."""
        return (self.measured,)

    def estimates(self) -> dict[str, Output]:
        """Return the outputs of the model, and the sensitivity."""
        known = self.model.outputs()
        found = {name: known[name] for name in self._shown_outputs()}
        return found | {"sensitivity": Output("1", "change of ln R with the fraction", "s")}

    def _shown_outputs(self) -> list[str]:
        (port,) = self.model.actuators()
        own = (*hidden_states.list_names(self.model), *self.model.mechanism.outputs())
        chosen = list_several(self.wanted) or (*own, self.model.label(port, "strain"), self.measured)
        return list(dict.fromkeys(chosen))

    def rest(self, xp: Namespace, readings: Named, signals: Named) -> tuple[Column, Column]:
        """Return the model at rest."""
        applied = list_required(self, signals)
        return self._list_estimates(xp, self.model.init(xp, *applied), applied)

    def update(
        self, xp: Namespace, memory: Column, readings: Named, signals: Named, dt: Scalar, turns: int
    ) -> tuple[Column, Column]:
        """Return the estimates at the root, and the state of the model there."""
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
            share = (ohms(xp, fraction) - first) * per
            return xp.where(flat, fraction - expected, share - wanted)

        bracket = -BEYOND, 1.0 + BEYOND
        root = solve_bracketed(xp, beyond, wanted, bracket, ITERATIONS)
        fresh = readings[f"{self.measured}.age"] <= 1e-9 * dt
        share = xp.where(fresh, dt / (self.lag + dt), 0.0)
        fraction = xp.clip(expected + share * (root - expected), 0.0, 1.0)
        there = hidden_states.place_hidden(xp, self.model, state, (temperature, fraction), applied)
        return self._list_estimates(xp, there, applied)

    def _ohms(self, xp: Namespace, state: Any, at: Column, signals: Column) -> Scalar:
        """Return the resistance [ohm] of a state put elsewhere."""
        there = hidden_states.place_hidden(xp, self.model, state, at, signals)
        return hidden_states.observe_model(xp, self.model, there, signals)[self.measured]

    def _list_estimates(self, xp: Namespace, state: Any, signals: Column) -> tuple[Column, Column]:
        found = hidden_states.observe_model(xp, self.model, state, signals)
        temperature, fraction = (found[name] for name in hidden_states.list_names(self.model))

        def ohms(xp: Namespace, fraction: Scalar) -> Scalar:
            return self._ohms(xp, state, (temperature, fraction), signals)

        value, slope = value_and_slope(xp, ohms, fraction)
        estimates = [*(found[name] for name in self._shown_outputs()), slope / value]
        return estimates, flatten_numbers(state)
