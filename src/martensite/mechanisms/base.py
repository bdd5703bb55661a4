"""What every mechanism answers: it takes its elements through a step together with itself.

A mechanism pulls on one or several elements, each at a port of its own, and may have signals
of its own, such as the voltage of a motor. To it an element is a `Load`: something that
advances when it is told which force a spring of its kind meets (`martensite.elements.base`).

Two families: a load line (`load_line`) answers in closed form for one element; a multibody
mechanism (`multibody`) has coordinates, any number of elements, and inertia if it is wanted.
Every mechanism is assembled with its elements in their initial state.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple

from martensite.elements.base import AbstractElement, Heating, Pull
from martensite.laws.coupling import Report
from martensite.mechanisms.drawing import Reading, Shape, hanging, lifted
from martensite.parameters import Parametrised
from martensite.registry import Registry
from martensite.runtimes.namespace import Namespace, Scalar

MECHANISMS: Registry[AbstractMechanism] = Registry("mechanism", "martensite.mechanisms")

Column = Sequence[Scalar]


class Output(NamedTuple):
    """How a quantity that can be observed is called."""

    unit: str
    """In SI."""
    long_name: str
    symbol: str


class Energy(NamedTuple):
    """What a mechanism holds [J], but for a constant, and what it gives away."""

    springs: Scalar
    """Elastic, without the shape-memory elements."""
    gravity: Scalar
    kinetic: Scalar
    """Of motion; of the current in a coil, too."""
    spent: Scalar
    """Power [W] that goes into friction and damping, less what motors give."""


class Work(NamedTuple):
    """A force [N] that does work on the outside, and its way [m]."""

    force: Scalar
    way: Scalar


class Load(NamedTuple):
    """An element at a port of a mechanism."""

    element: AbstractElement
    state: Any
    heating: Heating


class AbstractMechanism(Parametrised):
    """Interface of a mechanism."""

    static: ClassVar[bool] = False
    """True if it takes one element, has no signal, and offers a `load_line`."""

    def ports(self) -> tuple[str, ...]:
        """Names of the elements that it takes."""
        return ("element",)

    def signals(self) -> dict[str, str]:
        """Names of its own drive signals, with their units."""
        return {}

    def outputs(self) -> dict[str, Output]:
        """What can be observed on the mechanism itself; the first is its stroke."""
        raise NotImplementedError

    def judged(self) -> dict[str, float]:
        """Outputs whose convergence is judged, with the least range that counts."""
        raise NotImplementedError

    def first_step(self) -> float:
        """Longest step [s] with which a run may begin, for the sake of the mechanism."""
        return float("inf")

    def sample_time(self) -> float:
        """Time from sample to sample [s], if it is known at samples alone; else 0."""
        return 0.0

    def start_forces(self, xp: Namespace) -> Column:
        """Force [N] on each element when it is assembled."""
        raise NotImplementedError

    def first_forces(self, xp: Namespace, signals: Column) -> Column:
        """The same under the first signals, where these prescribe forces."""
        return self.start_forces(xp)

    def init(
        self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column,
        signals: Column,
    ) -> Any:  # fmt: skip
        """The memory at the start, from the elongations [m] that the start forces give."""
        raise NotImplementedError

    def advance(
        self, xp: Namespace, memory: Any, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[Any, list[Any], Report]:  # fmt: skip
        """Memory and states of the elements after a step of dt [s], and how well it was solved."""
        raise NotImplementedError

    def energy(
        self, xp: Namespace, memory: Any, loads: Sequence[Load], signals: Column
    ) -> Energy | None:
        """What it holds and gives away in a state; None if it does not say."""
        return None

    def ways(
        self, xp: Namespace, memory: Any, loads: Sequence[Load], forces: Column
    ) -> list[Scalar]:
        """How far the end of each element has moved under these forces [N], as it shortens [m]."""
        rows = zip(loads, forces, strict=True)
        return [-load.element.elongation(xp, load.state, force) for load, force in rows]

    def outside(
        self, xp: Namespace, memory: Any, loads: Sequence[Load], signals: Column
    ) -> list[Work]:
        """The forces with which it does work on something else."""
        return []

    def load_line(self, memory: Any) -> Pull:
        """What the element of a `static` mechanism meets, at any time."""
        raise NotImplementedError

    def observe(
        self, xp: Namespace, memory: Any, loads: Sequence[Load], signals: Column
    ) -> tuple[list[Scalar], Column]:
        """Force [N] in each element, and the `outputs` in order."""
        raise NotImplementedError

    def drawn(self, reading: Reading) -> list[Shape]:
        """What it looks like (`martensite.mechanisms.drawing`); the same shapes at every time.

        One that says nothing is drawn as elements that hang, moved or turned by its first output;
        without elements, as a ball on a thread.
        """
        name, output = next(iter(self.outputs().items()))
        value, ports = reading.outputs[name], self.ports()
        if not ports and output.unit == "m":
            return lifted(value)
        shortened = [value if output.unit == "m" else 0.0] * len(ports)
        return hanging(ports, shortened, [value] if output.unit == "rad" else [], reading)
