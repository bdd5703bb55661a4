"""Mechanisms with coordinates q, any number of elements, and optional inertia.

A subclass defines its geometry and its mechanics,

    contraction(q)      shortening of the path of each element from home
    demand(q, q', q'')  generalised force that the elements must supply for this motion

With the Jacobian J = d(contraction)/dq by automatic differentiation, and the tensions F of the elements, the equations
of motion at the end of every step are

    demand_k = Σ_i η_i F_i J_ik,        elongation_i = home_i - contraction_i(q) where taut

with the transmitted fraction η of the tension (1 without friction). No element can push.
`martensite.actuators.mechanics.condensed_step` solves them together with the laws of the elements, implicit in every
stress: no force lags behind the motion.

Sign convention: contraction and tension positive, so a positive J means that the element increases its coordinate.
Angles in rad.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from martensite.actuators.elements.base import AbstractElement, Effort
from martensite.actuators.mechanics import condensed_step
from martensite.actuators.mechanics.elimination import multiply_inner, solve_linear
from martensite.actuators.mechanics.motion import Motion, MotionHistory, Scheme, move_dynamically, quasi_static
from martensite.actuators.mechanisms.base import (
    AbstractMechanism,
    Column,
    Load,
    MechanicalEnergy,
    Mechanics,
    Output,
    Readout,
)
from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState, draw_hanging
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels import floats
from martensite.kernels.dual import compute_jacobian
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.recordable_numbers import xp
from martensite.physics.laws.coupling import StepReport


class Coordinate(NamedTuple):
    """Coordinate of a mechanism."""

    name: str
    unit: str
    """`rad`, `m`, or another SI unit."""
    long_name: str
    symbol: str
    size: float
    """Significant change in `unit`, the scale of convergence."""


class MultibodyMemory(NamedTuple):
    """Memory of a multibody mechanism."""

    home: tuple[Scalar, ...]
    """Elongation of each element at home [m]."""
    course: MotionHistory
    stiffness: tuple[Scalar, ...]
    """Stiffness of each element over the last step, including transformation [N/m]."""
    reactions: tuple[Scalar, ...] = ()
    """Reactions of its unilateral constraints [N] or [N m]."""


def find_balance(
    missing: Callable[[Namespace, Column], Column], place: Sequence[float], loose: Sequence[int]
) -> list[float]:
    """Return the place near `place` where nothing is missing along the `loose` coordinates, on floats.

    Raises:
        ParameterError: Newton's method finds no such place.
    """
    solution = list(place)
    for _ in range(100):
        left, slopes = compute_jacobian(floats, missing, solution)
        change = solve_linear([[slopes[i][j] for j in loose] for i in loose], [[left[i] for i in loose]])[0]
        for k, by in zip(loose, change, strict=True):
            solution[k] = solution[k] - by
        if all(abs(by) <= 1e-13 * (1.0 + abs(solution[k])) for k, by in zip(loose, change, strict=True)):
            return solution
    raise ParameterError("There is no place near home where elements and mechanism are in balance in that state.")


class AbstractMultibody(AbstractMechanism):
    """Mechanism with coordinates, which are zero at home by default."""

    motion: str = option(
        "how it moves: without inertia (`quasi-static`), or with it (`dynamic`)",
        "quasi-static",
        "dynamic",
        default="quasi-static",
    )
    rho_inf: Number = param("1", "share of the fastest oscillation that a step keeps", low=0.0, high=1.0, default=0.8)

    # ---------------------------------------------------------------- defined by subclasses

    @abstractmethod
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Return its coordinates."""

    @abstractmethod
    def contraction(self, xp: Namespace, position: Column) -> Column:
        """Return the shortening of the path of each element from home [m]."""

    @abstractmethod
    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        """Return the generalised forces [N] or [N m] that the elements must supply for a motion."""

    def home(self, xp: Namespace) -> Column:
        """Return the coordinates as assembled."""
        return [0.0] * len(self.coordinates())

    def assembled_elongations(self, xp: Namespace, elongations: Column) -> Column:
        """Return the elongation of each element at home [m], from those under the start forces."""
        return elongations

    def transmission(self, xp: Namespace, motion: Motion) -> Column:
        """Return the transmitted fraction of each tension; below 1 with resisting friction."""
        return [1.0] * len(self.ports())

    def gaps(self, xp: Namespace, position: Column) -> Column:
        """Return the gaps [m] or [rad] that never fall below zero; at home they are open, or just closed."""
        return []

    def energy(self, xp: Namespace, motion: Motion) -> MechanicalEnergy | None:
        """Return the energy in a motion; its kinetic part is ignored without inertia.

        Together with `dissipative` and `external_forces` it must account for all of `demand`. None means no work
        balance.
        """
        return None

    def dissipative(self, xp: Namespace, motion: Motion) -> Column:
        """Return the dissipative part of `demand` [N] or [N m]: by default `damping` times each rate."""
        damping = getattr(self, "damping", 0.0)
        return [damping * rate for rate in motion.velocity]

    def external_forces(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        """Return the generalised forces [N] or [N m] from outside, which reduce `demand`."""
        return [0.0] * len(motion.position)

    # ---------------------------------------------------------------- derived

    @property
    def moves(self) -> bool:
        """Return True with inertia."""
        return self.motion == "dynamic"

    @override
    def outputs(self) -> dict[str, Output]:
        outputs = {c.name: Output(c.unit, c.long_name, c.symbol) for c in self.coordinates()}
        if self.moves:
            outputs |= {
                f"{c.name}_rate": Output(f"{c.unit}/s", f"rate of {c.long_name}", f"{c.symbol}'")
                for c in self.coordinates()
            }
        return outputs

    @override
    def convergence_scales(self) -> dict[str, float]:
        return {c.name: 1e-3 * c.size for c in self.coordinates()}

    @override
    def init(
        self, xp: Namespace, elements: Sequence[AbstractElement], elongations: Column, signals: Column
    ) -> MultibodyMemory:
        rest = (0.0,) * len(self.coordinates())
        place = tuple(self.home(xp))
        course = self._begin(xp, Motion(place, rest, rest), self.start_forces(xp), signals)
        unknown = (0.0,) * len(elements)
        untouched = (0.0,) * len(self.gaps(xp, place))
        return MultibodyMemory(tuple(self.assembled_elongations(xp, elongations)), course, unknown, untouched)

    @override
    def initial_numbers(self) -> dict[str, str]:
        units = {c.name: c.unit for c in self.coordinates()}
        return units | {n: f"{c.unit}/s" for c, n in zip(self.coordinates(), self.rate_names(), strict=self.moves)}

    def rate_names(self) -> tuple[str, ...]:
        """Return the names of the rates of the coordinates; empty without inertia."""
        return tuple(f"{c.name}_rate" for c in self.coordinates()) if self.moves else ()

    def set_initial(
        self, memory: MultibodyMemory, given: Mapping[str, float], loads: Sequence[Load], signals: Column
    ) -> tuple[MultibodyMemory, list[float]]:
        """Return the memory at given coordinates and rates, and the tensions there; too long elements are slack.

        A coordinate without inertia and damping follows from the balance of forces.

        Raises:
            ParameterError: a coordinate follows from the elements, forces do not balance, or bodies would overlap.
        """
        rest = (0.0,) * len(self.coordinates())
        rows = list(zip(self.coordinates(), self.home(floats), strict=True))
        place = [given.get(c.name, home) for c, home in rows]
        velocity = tuple(given.get(name, 0.0) for name in self.rate_names()) or rest
        springs = [one.element.tangent(floats, one.state, one.element.force(one.state)) for one in loads]

        def pull(xp: Namespace, position: Column) -> Column:
            reach = [home - by for home, by in zip(memory.home, self.contraction(xp, position), strict=True)]
            return [xp.maximum((r - s.free) / s.compliance, 0.0) for r, s in zip(reach, springs, strict=True)]

        def missing(xp: Namespace, position: Column) -> Column:
            needs = self.demand(xp, Motion(tuple(position), rest, rest), signals)
            return [n - s for n, s in zip(needs, self.supply(xp, position, pull(xp, position), rest), strict=True)]

        loose: Sequence[int] = [] if self.moves else self._list_loose(given)
        place = find_balance(missing, place, loose) if loose else place
        overlap = -min(self.gaps(floats, place), default=0.0)
        if overlap > 1e-12:
            raise ParameterError(
                f"`{self.registered_name}` would overlap what it touches by {overlap:.3g} m or rad in that state; "
                "give coordinates that are farther from its stops and its object."
            )
        forces = list(pull(floats, place))
        return memory._replace(
            course=self._begin(floats, Motion(tuple(place), velocity, rest), forces, signals)
        ), forces

    def _list_loose(self, given: Mapping[str, float]) -> list[int]:
        """Return the coordinates without resistance; `ParameterError` if one of them is given."""
        count = len(self.coordinates())
        friction = self.dissipative(floats, Motion(tuple(self.home(floats)), (1.0,) * count, (0.0,) * count))
        loose = [k for k, force in enumerate(friction) if not force]
        for name in (self.coordinates()[k].name for k in loose):
            if name in given:
                raise ParameterError(
                    f"`{name}` of `{self.registered_name}` follows from its elements at once, since it has neither "
                    'inertia nor damping; set `motion = "dynamic"`, or a `damping`.'
                )
        return loose

    def _begin(self, xp: Namespace, motion: Motion, forces: Column, signals: Column) -> MotionHistory:
        """Return the initial motion under tensions [N]."""
        pull = self.supply(xp, motion.position, forces, motion.velocity)
        start = self.release(xp, motion, pull, signals)
        return MotionHistory(*motion[:2], start, start) if self.moves else MotionHistory(*motion[:2])

    def release(self, xp: Namespace, motion: Motion, supply: Column, signals: Column) -> tuple[Scalar, ...]:
        """Return the accelerations of the coordinates under given generalised forces."""
        if not self.moves:
            return motion.acceleration

        def needed(xp: Namespace, acceleration: Column) -> Column:
            return self.demand(xp, motion._replace(acceleration=tuple(acceleration)), signals)

        rest = [0.0] * len(motion.position)
        needs, inertia = compute_jacobian(xp, needed, rest)
        free = [s - n for s, n in zip(supply, needs, strict=True)]
        return tuple(solve_linear(inertia, [free])[0])

    def supply(self, xp: Namespace, position: Column, forces: Column, velocity: Column) -> list[Scalar]:
        """Return the generalised forces [N] or [N m] of given tensions [N]."""
        if not self.ports():
            return [0.0] * len(position)
        _, lever = compute_jacobian(xp, self.contraction, position)
        motion = Motion(tuple(position), tuple(velocity), (0.0,) * len(position))
        shares = self.transmission(xp, motion)
        arriving = [share * force for share, force in zip(shares, forces, strict=True)]
        return [multiply_inner(arriving, column) for column in zip(*lever, strict=True)]

    def scheme(self, xp: Namespace, course: MotionHistory, dt: Scalar) -> Scheme:
        """Return the scheme of velocity and acceleration from the final position of a step."""
        if self.moves:
            return move_dynamically(xp, course, dt, self.rho_inf)
        return quasi_static(xp, course, dt)

    @override
    def advance(
        self, xp: Namespace, memory: MultibodyMemory, loads: Sequence[Load], signals: Column, dt: Scalar
    ) -> tuple[MultibodyMemory, list[Any], StepReport]:
        step = condensed_step.CondensedStep(self, memory, loads, signals, dt)
        course, stiffness, reactions, states, report = step.solve_position(xp)
        return MultibodyMemory(memory.home, course, tuple(stiffness), reactions), states, report

    @override
    def observe(self, xp: Namespace, memory: MultibodyMemory, loads: Sequence[Load], signals: Column) -> Readout:
        forces = [element.force(state) for element, state, _ in loads]
        now = memory.course
        return forces, [*now.position, *(now.velocity if self.moves else ())]

    @override
    def mechanics(
        self, xp: Namespace, memory: MultibodyMemory, loads: Sequence[Load], signals: Column
    ) -> Mechanics | None:
        motion = memory.course.motion()
        energy = self.energy(xp, motion)
        if energy is None:
            return None
        energy = energy if self.moves else energy._replace(kinetic=0.0)
        rows = zip(
            self.dissipative(xp, motion), self.external_forces(xp, motion, signals), motion.position, strict=True
        )
        efforts = [(Effort(taken, q), Effort(-given, q)) for taken, given, q in rows]
        dissipated, outside = zip(*efforts, strict=True)
        paths = self.contraction(xp, motion.position)
        ways, rubbed = list[Scalar](), list[Effort]()
        shares = self.transmission(xp, motion)
        for (element, state, _), home, path, share in zip(loads, memory.home, paths, shares, strict=True):
            force = element.force(state)
            taut = home - element.elongation(xp, state, force)
            ways.append(xp.where(force > 0.0, taut, path))
            rubbed.append(Effort((1.0 - share) * force, path))
        return Mechanics(energy, tuple(ways), (*dissipated, *rubbed), outside)

    @override
    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        home = self.home(xp)
        place = [reading.outputs.get(c.name, h) for c, h in zip(self.coordinates(), home, strict=True)]
        turned = [q for c, q in zip(self.coordinates(), place, strict=True) if c.unit == "rad"]
        shortened = list(self.contraction(xp, place))
        return draw_hanging(self.ports(), shortened, turned, reading)
