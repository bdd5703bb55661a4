"""A plant with the noise that a filter reckons with: what its consistency is judged on.

    T ← T + q_T n₁ √T_n dt/T_n,     ξ ← ξ + q_ξ n₂ √T_n dt/T_n        after every step of dt

with standard normal numbers n from outside, drawn anew after every T_n: over that time both take a step of a random
walk with the densities q. Their drives are called `noise.temperature` and `noise.martensite_fraction`, with the port in
between on a machine, and `simulate_bench` draws them like those of sensors. Fractions stay within [0, 1], so that
beside the transformation the noise is less than what a filter assumes.
"""

from __future__ import annotations

from typing import Any

from martensite.actuators.assembly import AbstractSystem, Actuator
from martensite.actuators.assembly.base import DriveSignal
from martensite.actuators.mechanisms.base import AbstractMechanism, Column, Output
from martensite.base.parameters import param, part
from martensite.control.observers import hidden_states
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.coupling import StepReport

NOISE = "noise."


class ProcessNoisePlant(AbstractSystem):
    """A system whose temperatures and fractions do a random walk besides."""

    plant: AbstractSystem = part("what is shaken")
    temperature_noise: Scalar = param("K/s^0.5", "of the temperature", low=0.0, default=0.5)
    fraction_noise: Scalar = param("1/s^0.5", "of the martensite fraction", low=0.0, default=0.02)
    held: Scalar = param("s", "how long a number holds", above=0.0)

    def check(self) -> None:
        """Raise `ParameterError` if its elements have no single temperature."""
        hidden_states.build_example(self.plant)

    @property
    def mechanism(self) -> AbstractMechanism:  # type: ignore[override]
        """That of the plant."""
        return self.plant.mechanism

    def actuators(self) -> dict[str, Actuator]:
        """Those of the plant."""
        return self.plant.actuators()

    def drives(self) -> list[DriveSignal]:
        """Those of the plant, then the numbers."""
        own = [DriveSignal(NOISE + name, "1", False) for name in hidden_states.list_names(self.plant)]
        return [*self.plant.drives(), *own]

    def label(self, port: str, name: str) -> str:
        """As on the plant."""
        return self.plant.label(port, name)

    def drive_at(self, port: str) -> str:
        """As on the plant."""
        return self.plant.drive_at(port)

    def outputs(self) -> dict[str, Output]:
        """Those of the plant."""
        return self.plant.outputs()

    def convergence_scales(self) -> dict[str, float]:
        """As on the plant."""
        return self.plant.convergence_scales()

    def description(self) -> str:
        """As the plant, shaken."""
        return f"{self.plant.description()}, shaken"

    def init(self, xp: Namespace, *drives: Scalar) -> Any:
        """The plant at rest."""
        return self.plant.init(xp, *self._apart(drives)[0])

    def step(self, xp: Namespace, state: Any, *drives: Scalar, dt: Scalar) -> tuple[Any, StepReport]:
        """A step of the plant, then one of the walk."""
        signals, numbers = self._apart(drives)
        after, report = self.plant.step(xp, state, *signals, dt=dt)
        share = dt / xp.sqrt(self.held)
        sizes = [self.temperature_noise, self.fraction_noise] * len(self.plant.actuators())
        at = hidden_states.read_hidden(xp, self.plant, after, signals)
        moved = [x + q * n * share for x, q, n in zip(at, sizes, numbers, strict=True)]
        return hidden_states.place_hidden(
            xp, self.plant, after, hidden_states.limit_fractions(xp, moved), signals
        ), report

    def observe(self, xp: Namespace, state: Any, *drives: Scalar) -> list[Scalar]:
        """What is seen of the plant."""
        return self.plant.observe(xp, state, *self._apart(drives)[0])

    def _apart(self, drives: Column) -> tuple[Column, Column]:
        """Signals of the plant, and the numbers."""
        count = len(self.plant.drives())
        return drives[:count], drives[count:]
