"""Hidden states of a system, which no sensor measures: temperature and martensite fraction at every port.

    x = (T, ξ) of every actuator,      state = placed(x)

Observers carry the whole state of their model along and correct x in it: the law keeps its history
(`AbstractLaw.moved`), and the stress is that at which element and mechanism fit. The oriented fraction is proportional
to ξ. It is not a separate unknown: the resistance does not depend on it, and in a wire under tension martensite is
oriented where it forms.
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
"""Names of the estimates at every port, in this order."""
SLIGHT = 1e-6
"""Fraction below which martensite is taken as oriented."""
REST = 300.0
"""A temperature to begin with where a source sets it [K]."""


def build_example(model: AbstractSystem) -> State:
    """Return a state of a model, as an example of the shape of all its states.

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
    """Return the names of all that is hidden."""
    return [model.label(port, name) for port in model.actuators() for name in HIDDEN]


def observe_model(xp: Namespace, model: AbstractSystem, state: Any, signals: Sequence[Scalar]) -> dict[str, Scalar]:
    """Return the outputs of a model by name."""
    return dict(zip(model.outputs(), model.observe(xp, state, *signals), strict=True))


def read_hidden(xp: Namespace, model: AbstractSystem, state: Any, signals: Sequence[Scalar]) -> list[Scalar]:
    """Return the hidden values of a state."""
    found = observe_model(xp, model, state, signals)
    return [found[name] for name in list_names(model)]


def place_hidden(
    xp: Namespace, model: AbstractSystem, state: State, at: Sequence[Scalar], signals: Sequence[Scalar]
) -> State:
    """Return the state with other hidden values, under forces at which everything fits."""
    for _ in range(2):
        found = observe_model(xp, model, state, signals)
        rows = zip(model.actuators().items(), state.elements, at[::2], at[1::2], strict=True)
        elements = [
            one.element.in_state(
                xp,
                element,
                _scale_fractions(xp, model, port, found, fraction),
                temperature,
                found[model.label(port, "force")],
            )
            for (port, one), element, temperature, fraction in rows
        ]
        state = State(tuple(elements), state.mechanism)
    return state


def limit_fractions(xp: Namespace, at: Sequence[Scalar]) -> list[Scalar]:
    """Return the hidden values with fractions in [0, 1]."""
    return [xp.clip(x, 0.0, 1.0) if k % 2 else x for k, x in enumerate(at)]


def _scale_fractions(
    xp: Namespace, model: AbstractSystem, port: str, found: Mapping[str, Scalar], fraction: Scalar
) -> Fractions:
    """Return the phase state of a port at another martensite fraction, oriented in proportion."""
    before, oriented = (found[model.label(port, name)] for name in ("martensite_fraction", "oriented_fraction"))
    some = before > SLIGHT
    share = xp.where(some, oriented / xp.where(some, before, 1.0), 1.0)
    return Fractions(fraction, xp.clip(share, -1.0, 1.0) * fraction)


NOISE = "noise."


class ProcessNoisePlant(AbstractSystemAround):
    """A system whose temperatures and fractions do a random walk besides.

        T ← T + q_T n₁ √T_n dt/T_n,     ξ ← ξ + q_ξ n₂ √T_n dt/T_n        after every step of dt

    with standard normal numbers n from outside, drawn again after every T_n: over that time both take a step of a
    random walk with the densities q. Their drives are called `noise.temperature` and `noise.martensite_fraction`, with
    the port in between on a machine, and `simulate_bench` draws them like those of sensors. Fractions stay within [0,
    1], so that beside the transformation the noise is less than what a filter assumes.
    """

    temperature_noise: Number = param("K/s^0.5", "random walk of the temperature", low=0.0, default=0.5)
    fraction_noise: Number = param("1/s^0.5", "random walk of the martensite fraction", low=0.0, default=0.02)
    held: Number = param("s", "how long a number holds", above=0.0)

    def check(self) -> None:
        """Raise `ParameterError` if its elements have no single temperature."""
        build_example(self.plant)

    def drives(self) -> list[DriveSignal]:
        """Return the drives of the plant, then those of the noise."""
        own = [DriveSignal(NOISE + name, "1", False) for name in list_names(self.plant)]
        return [*self.plant.drives(), *own]

    def description(self) -> str:
        """Describe the plant with its noise."""
        return f"{self.plant.description()}, shaken"

    def init(self, xp: Namespace, *drives: Scalar) -> Any:
        """Return the plant at rest."""
        return self.plant.init(xp, *self._apart(drives)[0])

    def step(self, xp: Namespace, state: Any, *drives: Scalar, dt: Scalar) -> tuple[Any, StepReport]:
        """Return a step of the plant, then one of the walk."""
        signals, numbers = self._apart(drives)
        after, report = self.plant.step(xp, state, *signals, dt=dt)
        share = dt / xp.sqrt(self.held)
        sizes = [self.temperature_noise, self.fraction_noise] * len(self.plant.actuators())
        at = read_hidden(xp, self.plant, after, signals)
        moved = [x + q * n * share for x, q, n in zip(at, sizes, numbers, strict=True)]
        return place_hidden(xp, self.plant, after, limit_fractions(xp, moved), signals), report

    def observe(self, xp: Namespace, state: Any, *drives: Scalar) -> list[Scalar]:
        """Return the outputs of the plant."""
        return self.plant.observe(xp, state, *self._apart(drives)[0])

    def _apart(self, drives: Column) -> tuple[Column, Column]:
        count = len(self.plant.drives())
        return drives[:count], drives[count:]
