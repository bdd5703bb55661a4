"""What the laws with thermally activated layers share: see `laws.barriers`, `laws.exchange`.

The four processes are, in this order, A → M+, M+ → A, A → M-, M- → A.
"""

from __future__ import annotations

from collections.abc import Sequence

from martensite.laws.barriers import (
    Material,
    Process,
    Start,
    mean_rate,
    processes,
    scales,
    wells,
)
from martensite.laws.exchange import Flows
from martensite.laws.layers import AbstractLayers, Pull
from martensite.parameters import param
from martensite.runtimes.namespace import Namespace, Scalar

RESTING = 0.03
"""Share of its layers that a process at rest is guessed to move in one step."""


class AbstractActivated(AbstractLayers):
    """Layers that jump over barriers at rates."""

    form = "barrier"

    layer_volume: Scalar = param("m^3", "volume of a transforming layer", above=0.0, high=1e-15)
    layer_time: Scalar = param("s", "time constant of a transforming layer", above=0.0, high=1e3)

    def material(self) -> Material:
        """Constants of the free energy and of the layers."""
        return Material(
            self.E_A, self.E_M, self.eps_T, self.Delta_sigma, self.layer_volume, self.layer_time
        )

    def barriers(self, xp: Namespace, stress: Scalar, temperature: Scalar) -> tuple[Process, ...]:
        """The four processes at a point."""
        constants = self.material()
        at = wells(xp, constants, self.threshold(temperature), temperature, self.form)
        plus = processes(xp, constants, at, stress, self.form)
        minus = processes(xp, constants, at, -stress, self.form)
        return (*plus, *minus)

    def flows(
        self, xp: Namespace, starts: Sequence[Start], ends: Sequence[Process], dt: Scalar
    ) -> Flows:
        """Mean rates times the step between the processes at its two ends."""
        share = dt / self.layer_time
        return Flows(*(share * mean_rate(xp, a, b) for a, b in zip(starts, ends, strict=True)))

    def driven(
        self, xp: Namespace, pull: Pull, stress: Scalar, temperature: Scalar, dt: Scalar
    ) -> Scalar:
        """How far the pulled process would end beyond where it rests in a step of dt [Pa]."""
        at = wells(xp, self.material(), self.threshold(temperature), temperature, self.form)
        scale = scales(xp, self.material(), at, self.form)
        slow = xp.sqrt(xp.log(xp.maximum(dt / (RESTING * self.layer_time), 1.0)))
        inside = slow / xp.where(pull.offset < 0.0, scale.M, scale.A)
        return self.overshoot(xp, pull, stress, temperature) + inside
