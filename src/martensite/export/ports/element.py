"""An element alone as a system: elongation, ambient and drive in; force, temperature, resistance out.

Its elongation [m] counts from the state in which it is mounted under a preload F₀. At the end of each step

    F = (e₀ + e - free)/compliance     while taut, else F = 0,

with the spring of the element at its phase fractions and temperature: a testing machine with a rigid frame. Heat, law
and resistance are solved with it, as in a run. The host moves the end.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from martensite.actuators.assembly import AbstractSystem, Actuator, Feed, System
from martensite.actuators.assembly.base import DriveSignal
from martensite.actuators.assembly.ledger import Entries
from martensite.actuators.elements.base import AbstractElement, Effort, Pull, Spring
from martensite.actuators.mechanisms.base import (
    AbstractMechanism,
    Column,
    Load,
    MechanicalEnergy,
    Mechanics,
    Output,
    Readout,
)
from martensite.base.errors import InputError, require_known
from martensite.base.parameters import Number, option, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.coupling import StepReport


class MountedEnd(NamedTuple):
    """State of a moved end."""

    elongation: Scalar
    """Elongation of the element as mounted [m]."""


class MovedEnd(AbstractMechanism):
    """End of an element that a host moves."""

    preload: Number = param("N", "force as mounted", low=0.0, high=1e6, default=0.0)
    velocity: str = option("whether its velocity is a signal too", "none", "given", default="none")

    def signals(self) -> dict[str, str]:
        """Return the displacement of the end from its mounted position, and optionally its velocity."""
        return {"elongation": "m"} | ({"velocity": "m/s"} if self.velocity == "given" else {})

    def outputs(self) -> dict[str, Output]:
        """Return the stiffness output."""
        return {"stiffness": Output("N/m", "stiffness at frozen phase fractions and temperature", "k")}

    def convergence_scales(self) -> dict[str, float]:
        """Return an empty table: the stress of the element stands for the force."""
        return {}

    def start_forces(self, xp: Namespace) -> Column:
        """Return the preload [N]."""
        return [self.preload]

    def init(
        self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column
    ) -> MountedEnd:
        """Return the mounted elongation."""
        return MountedEnd(elongations[0])

    def advance(
        self, xp: Namespace, memory: MountedEnd, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[MountedEnd, list[Any], StepReport]:
        """Return the step of the element, solved at the given displacement."""
        ((element, state, heating),) = loads
        after, report = element.advance(xp, state, heating, self._pull(memory, signals), dt)
        return memory, [after], report

    def observe(self, xp: Namespace, memory: MountedEnd, loads: Sequence[Load], signals: Column) -> Readout:
        """Return force and stiffness at the present displacement."""
        (load,) = loads
        force = load.meet_pull(xp, self._pull(memory, signals))
        taut = xp.where(force > 0.0, 1.0, 0.0)
        return [force], [taut / load.element.tangent(xp, load.state, force).compliance]

    def load_line(self, memory: MountedEnd) -> Pull:
        """Return the load line of the mounted end."""
        return self._pull(memory, (0.0,))

    def mechanics(self, xp: Namespace, memory: MountedEnd, loads: Sequence[Load], signals: Column) -> Mechanics:
        """Return the energy balance: the end works against the host; a slack element has no force."""
        ((element, state, _),) = loads
        force = element.force(state)
        taut = memory.elongation - element.elongation(xp, state, force)
        ways = (xp.where(force > 0.0, taut, -signals[0]),)
        return Mechanics(MechanicalEnergy(), ways, outside=(Effort(-force, signals[0]),))

    def _pull(self, memory: MountedEnd, signals: Column) -> Pull:
        def meet(xp: Namespace, spring: Spring) -> Scalar:
            force = (memory.elongation + signals[0] - spring.free) / spring.compliance
            return xp.where(force < 0.0, 0.0, force)

        return meet


class ElementPort(System):
    """An element with a moved end, in an ambient of given temperature."""

    def drives(self) -> list[DriveSignal]:
        """Return the drive of the element, the motion of its end, and the ambient temperature."""
        return [*super().drives(), DriveSignal("ambient", "K", False)]

    def outputs(self) -> dict[str, Output]:
        """Return the outputs of a system, and the ambient temperature."""
        return super().outputs() | {"ambient": Output("K", "ambient temperature", "T_a")}

    def description(self) -> str:
        """Return the description, such as `wire (brinson) with a moved end, driven by power`."""
        names = f"{self.element.registered_name} ({self.element.law.registered_name})"
        return f"{names} with a moved end, driven by {self.source.registered_name}"

    def list_cautions(self) -> list[str]:
        """Return an empty list: a tension element cannot be pushed."""
        return []

    def init(self, xp: Namespace, *drives: Scalar) -> Any:
        """Return the mounted steady state at the ambient temperature."""
        return super(ElementPort, self._place_port(drives)).init(xp, *drives[:-1])

    def step(self, xp: Namespace, state: Any, *drives: Scalar | Feed, dt: Scalar) -> tuple[Any, StepReport]:
        """Advance by dt [s]."""
        return super(ElementPort, self._place_port(drives)).step(xp, state, *drives[:-1], dt=dt)

    def observe(self, xp: Namespace, state: Any, *drives: Scalar) -> list[Scalar]:
        """Return the outputs of the system, and the ambient temperature."""
        return [*super(ElementPort, self._place_port(drives)).observe(xp, state, *drives[:-1]), drives[-1]]

    def flows(self, xp: Namespace, state: Any, *drives: Scalar | Feed) -> Scalar:
        """Return the power [W] into the element."""
        return super(ElementPort, self._place_port(drives)).flows(xp, state, *drives[:-1])

    def heat_contents(self, xp: Namespace, state: Any) -> list[Scalar | None]:
        """Return the heat content of the element, at its drive."""
        return [*super().heat_contents(xp, state), None]

    def entries(self, xp: Namespace, state: Any, *drives: Scalar) -> Entries:
        """Return the entries of the energy balance."""
        return super(ElementPort, self._place_port(drives)).entries(xp, state, *drives[:-1])

    def _place_port(self, drives: Sequence[Any]) -> ElementPort:
        """Return the port at the ambient temperature of the last drive."""
        return self.rebuilt({"environment.temperature": drives[-1]})


def build_element_port(
    system: AbstractSystem, *, port: str | None = None, preload: float | None = None, velocity: str = "none"
) -> ElementPort:
    """Return an element of a system, with its source and ambient, whose end a host moves.

    Args:
        system: the system.
        port: port of the element; may be omitted for a single one.
        preload: mounting force [N]; by default the start force of the system.
        velocity: `given` if the velocity of the end is an input.

    Raises:
        InputError: the port does not exist, or several ports need a choice.
    """
    from martensite.kernels import floats

    actuator, place = choose_actuator(system, port)
    if preload is None:
        preload = float(system.mechanism.start_forces(floats)[place])
    end = MovedEnd(preload=preload, velocity=velocity)
    return ElementPort(
        element=actuator.element, environment=actuator.environment, source=actuator.source, mechanism=end
    )


def choose_actuator(system: AbstractSystem, port: str | None) -> tuple[Actuator, int]:
    """Return the actuator at a port of a system, and the index of the port."""
    actuators = system.actuators()
    if not actuators:
        raise InputError("This system has no element.")
    if port is None and len(actuators) > 1:
        raise InputError(f"This system has {len(actuators)} elements; choose the port of one: {', '.join(actuators)}.")
    name = next(iter(actuators)) if port is None else port
    require_known("element at port", name, actuators)
    return actuators[name], list(actuators).index(name)
