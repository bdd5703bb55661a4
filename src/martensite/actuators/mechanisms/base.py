"""Interface of a mechanism: it advances its elements through a step together with itself.

A mechanism pulls on one or several elements, each at a separate port, and may have drive signals, such as the voltage
of a motor. It treats an element as a `Load`, which advances on the load line of a spring
(`martensite.actuators.elements.base`).

Two families: a load line (`load_line`) answers in closed form for one element; a multibody
mechanism (`multibody`) has coordinates, any number of elements, and inertia if it is wanted.
Every mechanism is assembled with its elements in their initial state.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

from martensite.actuators.elements.base import AbstractElement, Effort, Heating, Pull, Spring, equilibrium_force
from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState, draw_hanging, draw_lifted
from martensite.base.interfaces import make_missing_error, require_where
from martensite.base.parameters import Parametrised
from martensite.base.registry import Registry
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.coupling import StepReport

MECHANISMS: Registry[AbstractMechanism] = Registry(
    "mechanism", "martensite.actuators.mechanisms", typical="dead-weight"
)

Column = Sequence[Scalar]
Readout = tuple[list[Scalar], Column]
"""Force [N] in each element, and the `outputs` in order."""


class Output(NamedTuple):
    """Label of an observable quantity."""

    unit: str
    """In SI."""
    long_name: str
    symbol: str


class Load(NamedTuple):
    """An element at a port of a mechanism."""

    element: AbstractElement
    state: Any
    heating: Heating

    def meet_pull(self, xp: Namespace, pull: Pull) -> Scalar:
        """Return the force [N] at which the element, at frozen phase fractions and temperature, fits what it meets."""
        element, state, _ = self

        def tangent(xp: Namespace, force: Scalar) -> Spring:
            return element.tangent(xp, state, force)

        return equilibrium_force(xp, tangent, pull, element.force(state), element.passes)


class MechanicalEnergy(NamedTuple):
    """Mechanical energy that a mechanism holds [J], but for constants."""

    springs: Scalar = 0.0
    gravity: Scalar = 0.0
    kinetic: Scalar = 0.0
    magnetic: Scalar = 0.0
    """Magnetic energy of the winding of a motor."""


class Mechanics(NamedTuple):
    """Destinations of the work of the elements."""

    energy: MechanicalEnergy
    ways: tuple[Scalar, ...]
    """Displacement of the attachment of each element since assembly [m]: by its elongation where it is taut; by its
    path where it hangs slack and has a free end."""
    dissipated: tuple[Effort, ...] = ()
    """Friction, damping and losses of a motor, each along its way."""
    outside: tuple[Effort, ...] = ()
    """Efforts against the outside, such as the drive of a crosshead or a voltage."""


class AbstractMechanism(Parametrised):
    """Interface of a mechanism."""

    static: ClassVar[bool] = False
    """True if it takes one element, has no signal, and offers a `load_line`."""
    typical_scenario: ClassVar[str] = ""
    """A packaged scenario to begin with, where it needs other elements and drives than most."""

    def ports(self) -> tuple[str, ...]:
        """Return the names of the elements that it takes."""
        return ("element",)

    def signals(self) -> dict[str, str]:
        """Return the names of its drive signals, with their units."""
        return {}

    @abstractmethod
    def outputs(self) -> dict[str, Output]:
        """Return the outputs of the mechanism itself; the first is its stroke."""

    @abstractmethod
    def convergence_scales(self) -> dict[str, float]:
        """Return the outputs whose convergence is judged, with the least range that counts."""

    def first_step(self) -> float:
        """Return the longest step [s] with which a run may begin, for the sake of the mechanism."""
        return float("inf")

    def sample_time(self) -> float:
        """Return the time from sample to sample [s], if it is known at samples alone; else 0."""
        return 0.0

    @abstractmethod
    def start_forces(self, xp: Namespace) -> Column:
        """Return the force [N] on each element when it is assembled."""

    def first_forces(self, xp: Namespace, signals: Column) -> Column:
        """Return the forces at assembly under the first signals, if these prescribe forces."""
        return self.start_forces(xp)

    @abstractmethod
    def init(self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column) -> Any:
        """Return the memory at the start, from the elongations [m] that the start forces give."""

    def initial_numbers(self) -> dict[str, str]:
        """Return the coordinates and speeds that a run may start with, with units; empty if elements define them."""
        return {}

    def set_initial(
        self, memory: Any, given: Mapping[str, float], loads: Sequence[Load], signals: Column
    ) -> tuple[Any, list[float]]:
        """Return the memory with given `initial_numbers`, on floats; and the forces [N] of the elements."""
        return memory, self.observe(floats, memory, loads, signals)[0]

    @abstractmethod
    def advance(
        self, xp: Namespace, memory: Any, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[Any, list[Any], StepReport]:
        """Return the memory and states of the elements after a step of dt [s], and the report of the step."""

    @require_where("static")
    def load_line(self, memory: Any) -> Pull:
        """Return the load line of the element of a `static` mechanism, at any time."""
        raise make_missing_error(type(self), ["load_line"])

    @abstractmethod
    def observe(self, xp: Namespace, memory: Any, loads: Sequence[Load], signals: Column) -> Readout:
        """Return the force [N] in each element, and the `outputs` in order."""

    def mechanics(self, xp: Namespace, memory: Any, loads: Sequence[Load], signals: Column) -> Mechanics | None:
        """Return stored, dissipated and delivered energies; None if they are not known."""
        return None

    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        """Draw the mechanism (`.drawing`), with the same shapes at every time.

        One that says nothing is drawn as elements that hang, moved or turned by its first output;
        without elements, as a ball on a thread.
        """
        name, output = next(iter(self.outputs().items()))
        value, ports = reading.outputs[name], self.ports()
        if not ports and output.unit == "m":
            return draw_lifted(value)
        shortened = [value if output.unit == "m" else 0.0] * len(ports)
        return draw_hanging(ports, shortened, [value] if output.unit == "rad" else [], reading)
