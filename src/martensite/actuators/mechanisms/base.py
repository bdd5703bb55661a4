"""Interface of a mechanism, which advances itself and its elements through a step.

A mechanism has one or several elements, each at its own port, and may have drive signals, such as the voltage of a
motor. An element is a `Load`, which advances on the load line of a spring (`martensite.actuators.elements.base`).

Two families: a load line (`load_line`) has a closed form for one element; a multibody mechanism (`multibody`) has
coordinates, any number of elements, and optional inertia. Every mechanism is assembled with its elements in their
initial state.
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
    """SI unit."""
    long_name: str
    symbol: str


class Load(NamedTuple):
    """Element at a port of a mechanism."""

    element: AbstractElement
    state: Any
    heating: Heating

    def meet_pull(self, xp: Namespace, pull: Pull) -> Scalar:
        """Return the equilibrium force [N] at frozen phase fractions and temperature."""
        element, state, _ = self

        def tangent(xp: Namespace, force: Scalar) -> Spring:
            return element.tangent(xp, state, force)

        return equilibrium_force(xp, tangent, pull, element.force(state), element.passes)


class MechanicalEnergy(NamedTuple):
    """Stored mechanical energy [J], up to a constant."""

    springs: Scalar = 0.0
    gravity: Scalar = 0.0
    kinetic: Scalar = 0.0
    magnetic: Scalar = 0.0
    """Magnetic energy of a motor winding."""


class Mechanics(NamedTuple):
    """Destinations of the work of the elements."""

    energy: MechanicalEnergy
    ways: tuple[Scalar, ...]
    """Displacement of the attachment of each element since assembly [m]: by its elongation if taut; by its path if
    slack with a free end.
    """
    dissipated: tuple[Effort, ...] = ()
    """Friction, damping and motor losses, each along its path."""
    outside: tuple[Effort, ...] = ()
    """Efforts against the outside, such as the drive of a crosshead or a voltage."""


class AbstractMechanism(Parametrised):
    """Interface of a mechanism."""

    static: ClassVar[bool] = False
    """True if it has one element, no signal, and a `load_line`."""
    typical_scenario: ClassVar[str] = ""
    """Packaged scenario for the first steps, if the default elements and drives do not fit."""

    def ports(self) -> tuple[str, ...]:
        """Return the names of its elements."""
        return ("element",)

    def signals(self) -> dict[str, str]:
        """Return the names of its drive signals, with their units."""
        return {}

    @abstractmethod
    def outputs(self) -> dict[str, Output]:
        """Return the outputs of the mechanism; the first is its stroke."""

    @abstractmethod
    def convergence_scales(self) -> dict[str, float]:
        """Return the outputs with a convergence test -> smallest relevant range."""

    def first_step(self) -> float:
        """Return the longest first step [s] of a run."""
        return float("inf")

    def sample_time(self) -> float:
        """Return the sample time [s] if it is known at samples only; else 0."""
        return 0.0

    @abstractmethod
    def start_forces(self, xp: Namespace) -> Column:
        """Return the force [N] on each element at assembly."""

    def first_forces(self, xp: Namespace, signals: Column) -> Column:
        """Return the forces at assembly under the first signals, if these prescribe forces."""
        return self.start_forces(xp)

    @abstractmethod
    def init(self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column) -> Any:
        """Return the initial memory, from the elongations [m] under the start forces."""

    def initial_numbers(self) -> dict[str, str]:
        """Return the coordinates and speeds that a run may start with, with units; may be empty."""
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
        """Return stored, dissipated and delivered energies; None if unknown."""
        return None

    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        """Return the shapes of the mechanism (`.drawing`), the same shapes at every time.

        By default elements hang, moved or turned by the first output; without elements, a ball hangs on a thread.
        """
        name, output = next(iter(self.outputs().items()))
        value, ports = reading.outputs[name], self.ports()
        if not ports and output.unit == "m":
            return draw_lifted(value)
        shortened = [value if output.unit == "m" else 0.0] * len(ports)
        return draw_hanging(ports, shortened, [value] if output.unit == "rad" else [], reading)
