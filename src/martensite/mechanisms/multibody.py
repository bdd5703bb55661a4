r"""Mechanisms with coordinates q, any number of elements, and inertia if it is wanted.

A subclass answers for its geometry and its mechanics,

    contraction(q)      how much shorter the path of each element is than at home
    demand(q, q', q'')  generalised force that the elements must supply for this motion

and nothing else: with the Jacobian J = d(contraction)/dq, taken by dual numbers, and the
tensions F of the elements, the equations of motion at the end of every step are

    demand_k = Σ_i η_i F_i J_ik,        elongation_i = home_i - contraction_i(q) where taut

where η is what friction leaves of the tension (1 unless a mechanism says otherwise). No element
can push. `martensite.mechanisms.shared.condensed` solves them together with the laws of the
elements, implicit in every stress: at no time does a force lag behind the motion.

Sign convention: contraction and tension positive, so a positive J means that the element pulls
its coordinate up. Angles in rad.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from martensite.elements.base import AbstractElement
from martensite.laws.coupling import Report
from martensite.mechanisms.base import AbstractMechanism, Column, Energy, Load, Output
from martensite.mechanisms.drawing import Reading, Shape, hanging
from martensite.mechanisms.shared import condensed
from martensite.mechanisms.shared.elimination import inner, solutions
from martensite.mechanisms.shared.motion import Course, Motion, Scheme, dynamic, quasi_static
from martensite.parameters import option, param
from martensite.runtimes import floats
from martensite.runtimes.dual import jacobian, value_and_slope
from martensite.runtimes.namespace import Namespace, Scalar


class Coordinate(NamedTuple):
    """A coordinate of a mechanism."""

    name: str
    unit: str
    """`rad`, `m`, or another SI unit."""
    long_name: str
    symbol: str
    size: float
    """A change that matters, in `unit`: the scale of convergence."""


class Assembled(NamedTuple):
    """What a multibody mechanism remembers."""

    home: tuple[Scalar, ...]
    """Elongation of each element at home [m]."""
    course: Course
    stiffness: tuple[Scalar, ...]
    """Of each element over the last step, transformation included [N/m]."""


class AbstractMultibody(AbstractMechanism):
    """Interface of a mechanism with coordinates; they are zero at home unless it says so."""

    motion: str = option(
        "how it moves: without inertia (`quasi-static`), or with it (`dynamic`)",
        "quasi-static", "dynamic", default="quasi-static",
    )  # fmt: skip
    rho_inf: Scalar = param(
        "1", "share of the fastest oscillation that a dynamic step keeps",
        low=0.0, high=1.0, default=0.8,
    )  # fmt: skip

    # ---------------------------------------------------------------- a subclass answers

    def coordinates(self) -> tuple[Coordinate, ...]:
        """Its coordinates."""
        raise NotImplementedError

    def contraction(self, xp: Namespace, position: Column) -> Column:
        """Shortening of the path of each element from home [m]."""
        raise NotImplementedError

    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        """Generalised forces [N] or [N m] that the elements must supply for a motion."""
        raise NotImplementedError

    def home(self, xp: Namespace) -> Column:
        """The coordinates as assembled."""
        return [0.0] * len(self.coordinates())

    def mounted(self, xp: Namespace, elongations: Column) -> Column:
        """Elongation of each element at home [m], from those under the start forces."""
        return elongations

    def transmission(self, xp: Namespace, motion: Motion) -> Column:
        """Share of each tension that arrives: less than 1 where friction resists it."""
        return [1.0] * len(self.ports())

    def potential(self, xp: Namespace, position: Column) -> tuple[Scalar, Scalar] | None:
        """Energy [J] of springs, end stops included, and of weights; None if it does not say."""
        return None

    # ---------------------------------------------------------------- what follows

    @property
    def moves(self) -> bool:
        """True if inertia counts."""
        return self.motion == "dynamic"

    def outputs(self) -> dict[str, Output]:
        """The coordinates, and if inertia counts their rates."""
        found = {c.name: Output(c.unit, c.long_name, c.symbol) for c in self.coordinates()}
        if self.moves:
            found |= {
                f"{c.name}_rate": Output(f"{c.unit}/s", f"rate of {c.long_name}", f"{c.symbol}'")
                for c in self.coordinates()
            }
        return found

    def judged(self) -> dict[str, float]:
        """The coordinates."""
        return {c.name: 1e-3 * c.size for c in self.coordinates()}

    def init(
        self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column,
        signals: Column,
    ) -> Assembled:  # fmt: skip
        """At home and at rest; with inertia, under the acceleration that the signals give it."""
        rest = (0.0,) * len(self.coordinates())
        place = tuple(self.home(xp))
        pull = self.supply(xp, place, self.start_forces(xp), rest)
        start = self.release(xp, Motion(place, rest, rest), pull, signals)
        course = Course(place, rest, start, start) if self.moves else Course(place, rest)
        unknown = (0.0,) * len(elements)
        return Assembled(tuple(self.mounted(xp, elongations)), course, unknown)

    def release(
        self, xp: Namespace, motion: Motion, supply: Column, signals: Column
    ) -> tuple[Scalar, ...]:
        """Accelerations [of the coordinates] under given generalised forces."""
        if not self.moves:
            return motion.acceleration

        def needed(xp: Namespace, acceleration: Column) -> Column:
            return self.demand(xp, motion._replace(acceleration=tuple(acceleration)), signals)

        rest = [0.0] * len(motion.position)
        needs, inertia = jacobian(xp, needed, rest)
        free = [s - n for s, n in zip(supply, needs, strict=True)]
        return tuple(solutions(inertia, [free])[0])

    def supply(
        self, xp: Namespace, position: Column, forces: Column, velocity: Column
    ) -> list[Scalar]:
        """Generalised forces [N] or [N m] of given tensions [N]."""
        motion = Motion(tuple(position), tuple(velocity), (0.0,) * len(position))
        shares = self.transmission(xp, motion)
        arriving = [share * force for share, force in zip(shares, forces, strict=True)]
        return self.turn(xp, position, arriving)

    def energy(
        self, xp: Namespace, memory: Assembled, loads: Sequence[Load], signals: Column
    ) -> Energy | None:
        """Potential and kinetic energy, and what damping, friction and signals take from both."""
        course = memory.course
        rest = (0.0,) * len(course.position)
        motion = Motion(course.position, course.velocity, rest)
        held = self.potential(xp, motion.position)
        if held is None:
            return None
        forces = [element.force(state) for element, state, _ in loads]
        place, speed = motion.position, motion.velocity
        given = inner(self.turn(xp, place, forces), speed)
        rubbed = given - inner(self.supply(xp, place, forces, speed), speed)
        taken = inner(self.demand(xp, motion, signals), speed) - self.gain(xp, motion)
        return Energy(*held, self.kinetic(xp, motion), rubbed + taken)

    def ways(
        self, xp: Namespace, memory: Assembled, loads: Sequence[Load], forces: Column
    ) -> list[Scalar]:
        """Of their paths: a slack element has an end of its own [m]."""
        return list(self.contraction(xp, memory.course.position))

    def kinetic(self, xp: Namespace, motion: Motion) -> Scalar:
        """Half of the square velocity in the inertia, which `demand` is linear in [J]."""
        if not self.moves:
            return 0.0

        def needed(xp: Namespace, acceleration: Column) -> Column:
            signals = [0.0] * len(self.signals())
            return self.demand(xp, motion._replace(acceleration=tuple(acceleration)), signals)

        _, inertia = jacobian(xp, needed, [0.0] * len(motion.position))
        return 0.5 * inner(motion.velocity, [inner(row, motion.velocity) for row in inertia])

    def gain(self, xp: Namespace, motion: Motion) -> Scalar:
        """Rate of all energy along a motion that is not accelerated [W]."""

        def held(xp: Namespace, time: Scalar) -> Scalar:
            place = tuple(
                q + time * v for q, v in zip(motion.position, motion.velocity, strict=True)
            )
            springs, gravity = self.potential(xp, place) or (0.0, 0.0)
            return springs + gravity + self.kinetic(xp, motion._replace(position=place))

        return value_and_slope(xp, held, 0.0)[1]

    def turn(self, xp: Namespace, position: Column, forces: Column) -> list[Scalar]:
        """Generalised forces of tensions [N] from which friction takes nothing."""
        if not self.ports():
            return [0.0] * len(position)
        _, lever = jacobian(xp, self.contraction, position)
        return [inner(forces, column) for column in zip(*lever, strict=True)]

    def scheme(self, xp: Namespace, course: Course, dt: Scalar) -> Scheme:
        """How velocity and acceleration follow from the position at the end of a step."""
        if self.moves:
            return dynamic(xp, course, dt, self.rho_inf)
        return quasi_static(xp, course, dt)

    def advance(
        self, xp: Namespace, memory: Assembled, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[Assembled, list[Any], Report]:  # fmt: skip
        """Memory and states of the elements after a step of dt [s], and how well it was solved."""
        step = condensed.Step(self, memory, loads, signals, dt)
        course, stiffness, states, report = step.solved(xp)
        return Assembled(memory.home, course, tuple(stiffness)), states, report

    def observe(
        self, xp: Namespace, memory: Assembled, loads: Sequence[Load], signals: Column
    ) -> tuple[list[Scalar], Column]:
        """The tensions at the end of the last step, and the coordinates."""
        forces = [element.force(state) for element, state, _ in loads]
        now = memory.course
        return forces, [*now.position, *(now.velocity if self.moves else ())]

    def drawn(self, reading: Reading) -> list[Shape]:
        """Its elements, as they get shorter, and its angles, unless it has a shape of its own."""
        home = self.home(floats)
        place = [
            reading.outputs.get(c.name, h) for c, h in zip(self.coordinates(), home, strict=True)
        ]
        turned = [q for c, q in zip(self.coordinates(), place, strict=True) if c.unit == "rad"]
        shortened = [float(by) for by in self.contraction(floats, place)]
        return hanging(self.ports(), shortened, turned, reading)
