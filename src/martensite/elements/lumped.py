"""Elements with one phase state and one temperature.

Given the phase fractions at the end of a step, everything else follows in closed form:

    T    linearised trapezoid of the heat balance, with latent heat
    F    balance of the element (a spring at these fractions and T) with the mechanism

so the coupled step is the search for the fractions that the law answers with themselves
(`laws.coupling`). Second order in the step. An element that is not linear in force is
linearised at the force before, and again at the one found.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from martensite.elements.base import AbstractElement, Condition, Heating, Pull, Spring, fitted
from martensite.laws.base import Fractions
from martensite.laws.coupling import Report, advance
from martensite.runtimes.dual import value_and_slope
from martensite.runtimes.namespace import Namespace, Scalar
from martensite.thermal.base import Environment


class Lumped(NamedTuple):
    """State of a lumped element."""

    memory: Any
    """Of the law."""
    force: Scalar
    """[N]"""


class AbstractLumped(AbstractElement):
    """An element that is the same all over; a subclass answers for its shape."""

    def initial_fractions(self) -> Fractions:
        """Phase state at the start."""
        raise NotImplementedError

    def latent_heat_total(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> Scalar:
        """Heat released by the whole forward transformation [J] at (stress, temperature)."""
        raise NotImplementedError

    def spring(
        self, xp: Namespace, fractions: Fractions, temperature: Scalar, force: Scalar
    ) -> Spring:
        """Tangent at `force` [N] with frozen fractions and temperature [K]."""
        raise NotImplementedError

    def stress(self, xp: Namespace, force: Scalar) -> Scalar:
        """Stress [Pa] that drives the law, from the force [N]."""
        raise NotImplementedError

    def strain(self, xp: Namespace, elongation: Scalar) -> Scalar:
        """Strain [-] of the law, from the elongation [m]."""
        raise NotImplementedError

    def ohms(self, xp: Namespace, fraction: Scalar, strain: Scalar, temperature: Scalar) -> Scalar:
        """Resistance [ohm]."""
        raise NotImplementedError

    def init(self, xp: Namespace, force: Scalar, temperature: Scalar) -> Lumped:
        """The state at the start, under `force` [N] and at `temperature` [K]."""
        stress = self.stress(xp, force)
        return Lumped(self.law.init(xp, self.initial_fractions(), stress, temperature), force)

    def force(self, state: Lumped) -> Scalar:
        """Force at the end of the last step [N]."""
        return state.force

    def in_state(
        self, xp: Namespace, state: Lumped, fractions: Fractions, temperature: Scalar,
        force: Scalar,
    ) -> Lumped:  # fmt: skip
        """A state put elsewhere, with its history, under a force [N]."""
        stress = self.stress(xp, force)
        return Lumped(self.law.moved(xp, state.memory, fractions, stress, temperature), force)

    def tangent(self, xp: Namespace, state: Lumped, force: Scalar) -> Spring:
        """The element as a spring in a state, near a force [N]."""
        fractions = self.law.fractions(state.memory)
        return self.spring(xp, fractions, state.memory.temperature, force)

    def advance(
        self, xp: Namespace, state: Lumped, heating: Heating, pull: Pull, dt: Scalar
    ) -> tuple[Lumped, Report]:  # fmt: skip
        """The state after a step of dt [s], and how well the step was solved."""
        heat = self._heat_line(xp, state, heating, dt)

        def loaded(xp: Namespace, fractions: Fractions, temperature: Scalar) -> Scalar:
            def near(xp: Namespace, force: Scalar) -> Spring:
                return self.spring(xp, fractions, temperature, force)

            return fitted(xp, near, pull, state.force, self.passes)

        def settle(xp: Namespace, fractions: Fractions) -> tuple[Scalar, Scalar]:
            temperature = heat(xp, fractions.martensite)
            return self.stress(xp, loaded(xp, fractions, temperature)), temperature

        memory, report = advance(xp, self.law, state.memory, settle, dt)
        force = loaded(xp, self.law.fractions(memory), memory.temperature)
        return Lumped(memory, force), report

    def _heat_line(
        self, xp: Namespace, state: Lumped, heating: Heating, dt: Scalar
    ) -> Callable[[Namespace, Scalar], Scalar]:
        """T at the end of the step as a function of the fraction there."""
        imposed = heating.temperature
        if imposed is not None:
            return lambda xp, x: imposed
        law, memory = self.law, state.memory
        start, fractions = memory.temperature, law.fractions(memory)
        strain = law.strain(xp, fractions, memory.stress, start)

        def loss(xp: Namespace, temperature: Scalar) -> Scalar:
            return self.heat_loss(xp, temperature, heating.environment)

        lost, slope = value_and_slope(xp, loss, start)
        share = 1.0 / (self.heat_capacity_total() + 0.5 * dt * slope)
        latent = self.latent_heat_total(xp, memory.stress, start)

        def temperature(xp: Namespace, x: Scalar) -> Scalar:
            ohms = self.ohms(xp, 0.5 * (fractions.martensite + x), strain, start)
            current = heating.current(xp, ohms)
            joule = dt * (current * current * ohms - lost)
            return start + share * (joule + latent * (x - fractions.martensite))

        return temperature

    def condition(
        self, xp: Namespace, state: Lumped, force: Scalar, environment: Environment
    ) -> Condition:
        """Everything that can be measured on the element under a force [N]."""
        memory = state.memory
        fractions, temperature = self.law.fractions(memory), memory.temperature
        strain = self.strain(xp, self.elongation(xp, state, force))
        return Condition(
            temperature=temperature,
            hottest=temperature,
            martensite_fraction=fractions.martensite,
            oriented_fraction=fractions.oriented,
            stress=self.stress(xp, force),
            strain=strain,
            resistance=self.ohms(xp, fractions.martensite, strain, temperature),
            heat_loss=self.heat_loss(xp, temperature, environment),
        )
