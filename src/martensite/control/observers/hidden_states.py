"""Hidden states of a system: temperature and martensite fraction at every port.

    x = (T, ξ) of every actuator,      state = place_hidden(x)

Observers carry the whole state of their model and correct x in it: the law keeps its history (`AbstractLaw.moved`), and
the stress is in equilibrium with the mechanism. The oriented fraction is proportional to ξ, and no unknown: the
resistance does not depend on it, and in a wire under tension martensite forms oriented.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from martensite.actuators.assembly import AbstractSystem, State
from martensite.actuators.assembly.base import AbstractAssembly, AbstractSystemAround, DriveSignal
from martensite.actuators.mechanisms.base import Column
from martensite.actuators.mechanisms.multibody import AbstractMultibody
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.base import Fractions
from martensite.physics.laws.coupling import StepReport

HIDDEN = ("temperature", "martensite_fraction")
"""Names of the hidden states at every port."""
SLIGHT = 1e-6
"""Fraction below which martensite counts as oriented."""
REST = 300.0
"""Initial temperature where a source sets it [K]."""


def build_example(model: AbstractSystem) -> State:
    """Return an example of the states of a model.

    Raises:
        ParameterError: an observer cannot simulate this system.
    """
    if not isinstance(model, AbstractAssembly):
        raise ParameterError(
            f"An observer needs a `System` or a `Machine` as its model, but has a `{type(model).__name__}`."
        )
    mechanism = model.mechanism
    if isinstance(mechanism, AbstractMultibody) and mechanism.moves:
        raise ParameterError(
            f"An observer knows no inertia: give the `{mechanism.registered_name}` of its model "
            f'`motion = "quasi-static"`.'
        )
    signals = [REST if drive.unit == "K" else 0.0 for drive in model.drives()]
    state = model.init(floats, *signals)
    place_hidden(floats, model, state, read_hidden(floats, model, state, signals), signals)
    return state


def list_names(model: AbstractSystem) -> list[str]:
    """Return the names of all hidden states."""
    return [model.label(port, name) for port in model.actuators() for name in HIDDEN]


def observe_model(xp: Namespace, model: AbstractSystem, state: Any, signals: Sequence[Scalar]) -> dict[str, Scalar]:
    """Return the outputs of a model by name."""
    return dict(zip(model.outputs(), model.observe(xp, state, *signals), strict=True))


def read_hidden(xp: Namespace, model: AbstractSystem, state: Any, signals: Sequence[Scalar]) -> list[Scalar]:
    """Return the hidden values of a state."""
    outputs = observe_model(xp, model, state, signals)
    return [outputs[name] for name in list_names(model)]


def place_hidden(
    xp: Namespace, model: AbstractSystem, state: State, at: Sequence[Scalar], signals: Sequence[Scalar]
) -> State:
    """Return the state with other hidden values, in equilibrium with the mechanism."""
    for _ in range(2):
        outputs = observe_model(xp, model, state, signals)
        rows = zip(model.actuators().items(), state.elements, at[::2], at[1::2], strict=True)
        elements = [
            one.element.in_state(
                xp,
                element,
                _scale_fractions(xp, model, port, outputs, fraction),
                temperature,
                outputs[model.label(port, "force")],
            )
            for (port, one), element, temperature, fraction in rows
        ]
        state = State(tuple(elements), state.mechanism)
    return state


def limit_fractions(xp: Namespace, at: Sequence[Scalar]) -> list[Scalar]:
    """Return the hidden values with fractions in [0, 1]."""
    return [xp.clip(x, 0.0, 1.0) if k % 2 else x for k, x in enumerate(at)]


def _scale_fractions(
    xp: Namespace, model: AbstractSystem, port: str, outputs: Mapping[str, Scalar], fraction: Scalar
) -> Fractions:
    """Return the phase state of a port at another martensite fraction, with the same oriented part."""
    before, oriented = (outputs[model.label(port, name)] for name in ("martensite_fraction", "oriented_fraction"))
    some = before > SLIGHT
    ratio = xp.where(some, oriented / xp.where(some, before, 1.0), 1.0)
    return Fractions(fraction, xp.clip(ratio, -1.0, 1.0) * fraction)


NOISE = "noise."


class ProcessNoisePlant(AbstractSystemAround):
    """A system whose temperatures and fractions have an additional random walk.

        T ← T + q_T n₁ √T_n dt/T_n,     ξ ← ξ + q_ξ n₂ √T_n dt/T_n        after every step of dt

    The standard normal numbers n change after every T_n: over that time both take a step of a random walk with the
    densities q. The drives are `noise.temperature` and `noise.martensite_fraction`, with the port in between on a
    machine; `simulate_bench` draws them like sensor noise. Fractions stay within [0, 1], so that outside the
    transformation the noise is smaller than a filter assumes.
    """

    temperature_noise: Number = param("K/s^0.5", "random walk of the temperature", low=0.0, default=0.5)
    fraction_noise: Number = param("1/s^0.5", "random walk of the martensite fraction", low=0.0, default=0.02)
    held: Number = param("s", "time between two random numbers", above=0.0)

    def check(self) -> None:
        build_example(self.plant)

    def drives(self) -> list[DriveSignal]:
        own = [DriveSignal(NOISE + name, "1", False) for name in list_names(self.plant)]
        return [*self.plant.drives(), *own]

    def description(self) -> str:
        return f"{self.plant.description()}, shaken"

    def init(self, xp: Namespace, *drives: Scalar) -> Any:
        return self.plant.init(xp, *self._apart(drives)[0])

    # pyrefly: ignore[bad-override]  # signals are held over a step: it gets no moments
    def step(self, xp: Namespace, state: Any, *drives: Scalar, dt: Scalar) -> tuple[Any, StepReport]:
        signals, numbers = self._apart(drives)
        after, report = self.plant.step(xp, state, *signals, dt=dt)
        scale = dt / xp.sqrt(self.held)
        sizes = [self.temperature_noise, self.fraction_noise] * len(self.plant.actuators())
        at = read_hidden(xp, self.plant, after, signals)
        moved = [x + q * n * scale for x, q, n in zip(at, sizes, numbers, strict=True)]
        return place_hidden(xp, self.plant, after, limit_fractions(xp, moved), signals), report

    def observe(self, xp: Namespace, state: Any, *drives: Scalar) -> list[Scalar]:
        return self.plant.observe(xp, state, *self._apart(drives)[0])

    def _apart(self, drives: Column) -> tuple[Column, Column]:
        count = len(self.plant.drives())
        return drives[:count], drives[count:]
