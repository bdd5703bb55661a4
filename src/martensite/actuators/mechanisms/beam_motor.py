"""Motor with an unbalance at the tip of a beam: a non-ideal source, on which the beam acts back.

Tip displacement x, rotor angle φ and motor current i, under the voltage V. The unbalance m is at x + r sin φ; M is the
total moving mass including it, J the rotor inertia without it. Gravity is neglected.

    M x'' + c x' + k x = m r (φ'² sin φ - φ'' cos φ) + F_w
    (J + m r²) φ'' + m r x'' cos φ = K_T i - b φ' - F_c tanh(φ'/v₀)
    L i' = V - K_B φ' - R i

The third coordinate is the charge, with the rate i. With several beam modes, each scaled to unit displacement at the
tip (`martensite.actuators.mechanics.beam_modes`), x = Σ q_k and

    m_k q_k'' + c_k q_k' + k_k q_k = the right-hand side of the first equation,

all modes with the damping ratio of the first. A wire at the angle θ to the beam is tied to the tip; its path, with x
growing away from its clamp, and the effect of its tension F:

    l(x) = √[(l_w cos θ)² + (l_w sin θ + x)²],        F_w = -F (l_w sin θ + x)/l(x)

It is assembled without tension, with the elongation -s l_w beyond the unloaded hot wire (slack s), or just taut if that
would stretch it.

The mechanical energy of the isolated system is constant, except with `coupling = "printed"`, which is equation (3.15)
of the thesis, +φ'' cos φ in the first line, for comparison only.

Source: Kossoski (2018), chapter 4 and section 5.2.1, derived again with Lagrange's equations.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any

from martensite.actuators.mechanics.beam_drawing import drawn_beam
from martensite.actuators.mechanics.beam_modes import BeamModes
from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms.base import MECHANISMS, Column, Load, MechanicalEnergy, Output, Readout
from martensite.actuators.mechanisms.drawing import DrawingShape, DrawingState
from martensite.actuators.mechanisms.multibody import AbstractMultibody, Coordinate, MultibodyMemory
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, option, param
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import sum_column
from martensite.kernels.recordable_numbers import xp

MOST_MODES = 4
"""Largest number of modes."""


@MECHANISMS.register("beam-motor")
class BeamMotor(AbstractMultibody):
    """Unbalanced motor on a beam, with an optional wire at its tip."""

    typical_scenario = "closed_loop_beam"

    cites = ("kossoski2018",)

    motion: str = option("it always moves with inertia", "dynamic", default="dynamic")
    modes: str = option("modes of the beam that count", "1", "2", "3", "4", default="1")
    wire: str = option(
        "what is tied to the tip: nothing, or an element inclined to the beam", "none", "inclined", default="none"
    )
    coupling: str = option(
        "inertia of the unbalance in the equation of the tip: derived, or as in equation (3.15) "
        "of the thesis, which does not conserve energy",
        "lagrange",
        "printed",
        default="lagrange",
    )
    mass: Number = param("kg", "moving mass M of the first mode, with unbalance", above=0.0, high=1e4, typical="250 g")
    stiffness: Number = param("N/m", "stiffness k of the first mode", above=0.0, high=1e9, typical="541 N/m")
    damping: Number = param("N*s/m", "damping c of the first mode", low=0.0, high=1e6, typical="0.2 N*s/m")
    mass_2: Number = param("kg", "mass of the second mode", above=0.0, default=math.inf, typical="300 g")
    stiffness_2: Number = param("N/m", "stiffness of the second mode", above=0.0, default=math.inf, typical="2e4 N/m")
    mass_3: Number = param("kg", "mass of the third mode", above=0.0, default=math.inf, typical="400 g")
    stiffness_3: Number = param("N/m", "stiffness of the third mode", above=0.0, default=math.inf, typical="2e5 N/m")
    mass_4: Number = param("kg", "mass of the fourth mode", above=0.0, default=math.inf, typical="500 g")
    stiffness_4: Number = param("N/m", "stiffness of the fourth mode", above=0.0, default=math.inf, typical="1e6 N/m")
    unbalance: Number = param("kg", "mass m of the unbalance", low=0.0, high=1e3, typical="20 g")
    eccentricity: Number = param("m", "distance r of the unbalance from the axis", low=0.0, high=1.0, typical="20 mm")
    rotor_inertia: Number = param(
        "kg*m^2", "inertia J of the rotor without the unbalance", above=0.0, high=1e3, typical="8e-5 kg*m^2"
    )
    rotor_friction: Number = param(
        "N*m*s/rad", "viscous friction b of the rotor", low=0.0, high=1e3, default=0.0, typical="1e-5 N*m*s/rad"
    )
    dry_friction: Number = param("N*m", "rotor's dry friction F_c", low=0.0, high=1e3, default=0.0, typical="1e-4 N*m")
    friction_rate: Number = param(
        "rad/s", "rate v₀ over which dry friction changes sign", above=0.0, high=1e3, default=0.1, typical="5 rad/s"
    )
    torque_constant: Number = param("N*m/A", "torque per current K_T", low=0.0, high=1e3, typical="0.02 N*m/A")
    back_emf: Number = param("V*s/rad", "voltage per speed K_B", low=0.0, high=1e3, typical="0.02 V*s/rad")
    resistance: Number = param("ohm", "resistance R of the winding", above=0.0, high=1e6, typical="4 ohm")
    inductance: Number = param("H", "inductance L of the winding", above=0.0, high=1e3, typical="20 mH")
    wire_length: Number = param(
        "m", "length l_w of the path of the wire at x = 0", above=0.0, default=math.inf, typical="300 mm"
    )
    wire_angle: Number = param("rad", "angle θ of wire and beam at x = 0", low=0.0, high=1.57, default=math.pi / 12)
    slack: Number = param(
        "1",
        "how much longer than its path the unloaded hot wire is; negative: shorter",
        low=-0.2,
        high=0.2,
        default=0.0,
    )

    def check(self) -> None:
        """Raise `ParameterError` if values of a mode or of the wire are missing or invalid."""
        for k in range(2, self.count + 1):
            for name in (f"mass_{k}", f"stiffness_{k}"):
                if math.isinf(getattr(self, name)):
                    raise ParameterError(
                        f"`beam-motor` with modes = {self.modes} needs `{name}`; none given. "
                        "`modal_numbers` takes them from a beam."
                    )
        if self.ports() and math.isinf(self.wire_length):
            raise ParameterError('`beam-motor` with wire = "inclined" needs `wire_length` [m].')
        if self.unbalance > self.mass:
            raise ParameterError(
                f"Parameter `mass` of `beam-motor` holds the unbalance of {self.unbalance:.6g} kg "
                f"too, but is {self.mass:.6g} kg."
            )

    @property
    def count(self) -> int:
        """Return the number of modes."""
        return int(self.modes)

    @override
    def ports(self) -> tuple[str, ...]:
        return ("wire",) if self.wire == "inclined" else ()

    @override
    def signals(self) -> dict[str, str]:
        return {"motor": "V"}

    @override
    def coordinates(self) -> tuple[Coordinate, ...]:
        bends = [Coordinate("displacement", "m", "displacement of the tip", "x", 0.01)]
        if self.count > 1:
            numbers = range(1, self.count + 1)
            words = [(f"mode_{k}", f"tip displacement in mode {k}", f"q_{k}") for k in numbers]
            bends = [Coordinate(name, "m", long, symbol, 0.01) for name, long, symbol in words]
        angle = Coordinate("rotor_angle", "rad", "angle of the rotor", "φ", 1.0)
        return *bends, angle, Coordinate("charge", "A*s", "charge through the motor", "Q", 0.01)

    def _beam(self, xp: Namespace) -> Iterator[tuple[Scalar, Scalar, Scalar]]:
        """Yield mass, damping and stiffness of each mode."""
        yield self.mass, self.damping, self.stiffness
        for k in range(2, self.count + 1):
            mass, stiffness = getattr(self, f"mass_{k}"), getattr(self, f"stiffness_{k}")
            ratio = xp.sqrt((stiffness / self.stiffness) * (mass / self.mass))
            yield mass, self.damping * ratio, stiffness

    def path(self, xp: Namespace, displacement: Scalar) -> Scalar:
        """Return l(x) [m]."""
        along = self.wire_length * xp.cos(self.wire_angle)
        across = self.wire_length * xp.sin(self.wire_angle) + displacement
        return xp.sqrt(along * along + across * across)

    def contraction(self, xp: Namespace, position: Column) -> Column:
        """Return l_w - l(x) [m]."""
        if not self.ports():
            return []
        return [self.wire_length - self.path(xp, sum_column(position[: self.count]))]

    @override
    def start_forces(self, xp: Namespace) -> Column:
        return [0.0] * len(self.ports())

    def assembled_elongations(self, xp: Namespace, elongations: Column) -> Column:
        """Return -s l_w [m], limited to the elongation without tension."""
        return [xp.minimum(-self.slack * self.wire_length, free) for free in elongations]

    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        """Return the force on each mode [N], torque on the rotor [N m], voltage of the winding [V]."""
        n, (voltage,) = self.count, signals
        thrown = self.unbalance_force(xp, motion)
        rows = zip(self._beam(xp), *(column[:n] for column in motion), strict=True)
        bent = [m * a + c * v + k * q - thrown for (m, c, k), q, v, a in rows]
        return [*bent, *self.demand_rotor(xp, motion, voltage)]

    def unbalance_force(self, xp: Namespace, motion: Motion) -> Scalar:
        """Return the force [N] of the unbalance on the tip."""
        angle, speed, spin = (column[self.count] for column in motion)
        moment = self.unbalance * self.eccentricity
        cosine, sine = xp.cos(angle), xp.sin(angle)
        turned = -spin * cosine if self.coupling == "lagrange" else spin * cosine
        return moment * (speed * speed * sine + turned)

    def demand_rotor(self, xp: Namespace, motion: Motion, voltage: Scalar) -> Column:
        """Return rotor torque [N m] and winding voltage [V] of a motion, less a voltage [V]."""
        n = self.count
        angle, speed, spin = (column[n] for column in motion)
        current, change = motion.velocity[n + 1], motion.acceleration[n + 1]
        rubbed = self.dry_friction * xp.tanh(speed * (1.0 / self.friction_rate))
        moment, cosine = self.unbalance * self.eccentricity, xp.cos(angle)
        turning = self._turning() * spin + moment * sum_column(motion.acceleration[:n]) * cosine
        torque = turning + self.rotor_friction * speed + rubbed - self.torque_constant * current
        volts = self.inductance * change + self.resistance * current + self.back_emf * speed
        return [torque, volts - voltage]

    @override
    def energy(self, xp: Namespace, motion: Motion) -> MechanicalEnergy:
        n, moment = self.count, self.unbalance * self.eccentricity
        speed, current = motion.velocity[n], motion.velocity[n + 1]
        rows = list(zip(self._beam(xp), motion.position[:n], motion.velocity[:n], strict=True))
        bent = sum_column([k * q * q for (_, _, k), q, _ in rows])
        moved = sum_column([m * v * v for (m, _, _), _, v in rows]) + self._turning() * speed * speed
        shared = moment * sum_column(motion.velocity[:n]) * speed * xp.cos(motion.position[n])
        coil = 0.5 * self.inductance * current * current
        return MechanicalEnergy(springs=0.5 * bent, kinetic=0.5 * moved + shared, magnetic=coil)

    def dissipative(self, xp: Namespace, motion: Motion) -> Column:
        """Return the damping of the modes [N], friction of the rotor [N m], losses of the winding [V].

        If the voltage per speed exceeds the torque per current, the rotor gets less than the winding takes, and the
        difference is lost; the reverse would create energy.
        """
        n = self.count
        speed, current = motion.velocity[n], motion.velocity[n + 1]
        rows = zip(self._beam(xp), motion.velocity[:n], strict=True)
        rubbed = self.dry_friction * xp.tanh(speed * (1.0 / self.friction_rate))
        lost = xp.maximum(self.back_emf - self.torque_constant, 0.0) * speed
        bent = [c * v for (_, c, _), v in rows]
        return [*bent, self.rotor_friction * speed + rubbed, self.resistance * current + lost]

    @override
    def external_forces(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        return [0.0] * (self.count + 1) + [signals[0]]

    def resonance(self) -> Scalar:
        """Return √(k/M) of the first mode [rad/s]."""
        return xp.sqrt(self.stiffness / self.mass)

    def _turning(self) -> Scalar:
        """Return J + m r² [kg m²]."""
        return self.rotor_inertia + self.unbalance * self.eccentricity * self.eccentricity

    @override
    def outputs(self) -> dict[str, Output]:
        modes = self.coordinates()[: self.count] if self.count > 1 else ()
        return {
            "displacement": Output("m", "displacement of the tip", "x"),
            "velocity": Output("m/s", "velocity of the tip", "x'"),
            "rotor_angle": Output("rad", "angle of the rotor", "φ"),
            "rotor_speed": Output("rad/s", "speed of the rotor", "ω"),
            "motor_current": Output("A", "current of the motor", "i"),
            **{mode.name: Output(mode.unit, mode.long_name, mode.symbol) for mode in modes},
            "charge": Output("A*s", "charge through the motor", "Q"),
        }

    @override
    def rate_names(self) -> tuple[str, ...]:
        bends = [f"mode_{k}_rate" for k in range(1, self.count + 1)] if self.count > 1 else ["velocity"]
        return *bends, "rotor_speed", "motor_current"

    @override
    def convergence_scales(self) -> dict[str, float]:
        return {"displacement": 1e-5, "rotor_speed": 0.1}

    def first_step(self) -> float:
        """Return a fortieth of the shortest period of the beam [s]."""
        squares = [self.stiffness / self.mass]
        for k in range(2, self.count + 1):
            squares.append(getattr(self, f"stiffness_{k}") / getattr(self, f"mass_{k}"))
        return 2.0 * math.pi / math.sqrt(max(squares)) / 40.0

    @override
    def observe(self, xp: Namespace, memory: MultibodyMemory, loads: Sequence[Load], signals: Column) -> Readout:
        n, (position, velocity, *_) = self.count, memory.course
        bends = [sum_column(position[:n]), sum_column(velocity[:n])]
        turns = [position[n], velocity[n], velocity[n + 1]]
        modes = position[:n] if n > 1 else ()
        forces = [element.force(state) for element, state, _ in loads]
        return forces, [*bends, *turns, *modes, position[n + 1]]

    @override
    def draw_shapes(self, reading: DrawingState) -> list[DrawingShape]:
        return drawn_beam(self, reading)


def modal_numbers(modes: BeamModes) -> dict[str, Any]:
    """Return the arguments of `BeamMotor` for the modes of a beam: `modes`, masses and stiffnesses.

    Args:
        modes: up to four modes of a beam that carries the whole motor at its tip.

    Raises:
        ParameterError: there are more than four modes.
    """
    count = len(modes.omega)
    if count > MOST_MODES:
        raise ParameterError(f"`beam-motor` takes at most {MOST_MODES} modes, but {count} are given.")
    texts: dict[str, Any] = {"modes": str(count)}
    for k, (mass, stiffness) in enumerate(zip(modes.mass, modes.stiffness, strict=True), start=1):
        ending = "" if k == 1 else f"_{k}"
        texts |= {f"mass{ending}": mass, f"stiffness{ending}": stiffness}
    return texts
