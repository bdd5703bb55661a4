"""Variants of `beam-motor`: two motors on one beam, and a beam with a piezoelectric patch.

**Two motors** interact through the beam. The equations are those of `beam-motor` with a second rotor (parameters ending
in `_2`) at the same tip,

    M x'' + c x' + k x = Σ_j m_j r_j (φ_j'² sin φ_j - φ_j'' cos φ_j) + F_w,

and M includes both unbalances. Motors of different speed may then synchronise through the beam alone. A second motor on
a negative voltage turns the other way.

**The patch** adds, on the first mode of the beam q and with its voltage v,

    … + k q - θ v = …,        C_p v' + v/R_l + θ q' = 0.

v is the rate of the last coordinate, the flux λ = ∫ v dt. The power -θ v q' of the beam is the power v²/R_l in the
resistor plus the change of ½ C_p v², which is entered with the springs. Harmonic in q, V = -iωθR_l Q/(1 + iωR_lC_p):
without load, R_l → ∞, the patch stiffens the beam by θ²/C_p. It follows the curvature near the clamp and is not coupled
to higher modes here.

Source: Kossoski (2018), section 6.3, leaves several non-ideal sources and energy harvesting for later; Blekhman (1988)
for two motors; Erturk and Inman (2011), chapter 3, for the lumped patch.
"""

from collections.abc import Sequence
from typing import Self

from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms.base import MECHANISMS, Column, Load, MechanicalEnergy, Output, Readout
from martensite.actuators.mechanisms.beam_motor import BeamMotor
from martensite.actuators.mechanisms.multibody import Coordinate, MultibodyMemory
from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.parameters import Number, param
from martensite.kernels.namespace import Namespace
from martensite.kernels.nested import sum_column

ROTOR = ("unbalance", "eccentricity", "rotor_inertia", "rotor_friction", "torque_constant", "back_emf")
WINDING = ("resistance", "inductance")


@MECHANISMS.register("beam-motors")
class BeamMotors(BeamMotor):
    """Two unbalanced motors on a beam with equal dry friction, and an optional wire at its tip."""

    typical_scenario = "two_motors"

    cites = ("kossoski2018", "blekhman1988")

    unbalance_2: Number = param("kg", "mass of the second unbalance", low=0.0, high=1e3, typical="20 g")
    eccentricity_2: Number = param(
        "m", "distance of the second unbalance from the axis", low=0.0, high=1.0, typical="20 mm"
    )
    rotor_inertia_2: Number = param("kg*m^2", "inertia of the second rotor", above=0.0, typical="8e-5 kg*m^2")
    rotor_friction_2: Number = param(
        "N*m*s/rad", "viscous friction of the second rotor", low=0.0, high=1e3, default=0.0
    )
    torque_constant_2: Number = param(
        "N*m/A", "torque per current of the second motor", low=0.0, high=1e3, typical="0.02 N*m/A"
    )
    back_emf_2: Number = param(
        "V*s/rad", "voltage per speed of the second motor", low=0.0, high=1e3, typical="0.02 V*s/rad"
    )
    resistance_2: Number = param("ohm", "resistance of the second winding", above=0.0, high=1e6, typical="4 ohm")
    inductance_2: Number = param("H", "inductance of the second winding", above=0.0, high=1e3, typical="20 mH")

    @override
    def check(self) -> None:
        super().check()
        if self.unbalance + self.unbalance_2 > self.mass:
            raise ParameterError(
                f"Parameter `mass` of `beam-motors` holds both unbalances, but is {self.mass:.6g} kg, less than their "
                f"{self.unbalance + self.unbalance_2:.6g} kg."
            )

    def as_second_motor(self) -> Self:
        """Return the beam with the second motor."""
        return self.rebuilt({name: getattr(self, f"{name}_2") for name in (*ROTOR, *WINDING)})

    @override
    def signals(self) -> dict[str, str]:
        return {"motor": "V", "motor_2": "V"}

    @override
    def coordinates(self) -> tuple[Coordinate, ...]:
        return (
            *super().coordinates(),
            Coordinate("rotor_angle_2", "rad", "angle of the second rotor", "φ_2", 1.0),
            Coordinate("charge_2", "A*s", "charge through the second motor", "Q_2", 0.01),
        )

    @override
    def rate_names(self) -> tuple[str, ...]:
        return *super().rate_names(), "rotor_speed_2", "motor_current_2"

    @override
    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        first, second = super().demand(xp, motion, signals[:1]), self.as_second_motor()
        other = self._leave_first(motion)
        thrown = second.unbalance_force(xp, other)
        bent = [row - thrown for row in first[: self.count]]
        return [*bent, *first[self.count :], *second.demand_rotor(xp, other, signals[1])]

    @override
    def energy(self, xp: Namespace, motion: Motion) -> MechanicalEnergy:
        energy, second, n = super().energy(xp, motion), self.as_second_motor(), self.count
        angle, speed, current = motion.position[n + 2], motion.velocity[n + 2], motion.velocity[n + 3]
        shared = second.unbalance * second.eccentricity * sum_column(motion.velocity[:n]) * speed * xp.cos(angle)
        return energy._replace(
            kinetic=energy.kinetic + 0.5 * second._turning() * speed * speed + shared,
            magnetic=energy.magnetic + 0.5 * second.inductance * current * current,
        )

    @override
    def dissipative(self, xp: Namespace, motion: Motion) -> Column:
        other = BeamMotor.dissipative(self.as_second_motor(), xp, self._leave_first(motion))
        return [*super().dissipative(xp, motion), *other[self.count :]]

    @override
    def external_forces(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        return [*super().external_forces(xp, motion, signals[:1]), 0.0, signals[1]]

    @override
    def outputs(self) -> dict[str, Output]:
        return super().outputs() | {
            "rotor_angle_2": Output("rad", "angle of the second rotor", "φ_2"),
            "rotor_speed_2": Output("rad/s", "speed of the second rotor", "ω_2"),
            "motor_current_2": Output("A", "current of the second motor", "i_2"),
        }

    @override
    def convergence_scales(self) -> dict[str, float]:
        return super().convergence_scales() | {"rotor_speed_2": 0.1}

    @override
    def observe(self, xp: Namespace, memory: MultibodyMemory, loads: Sequence[Load], signals: Column) -> Readout:
        forces, own = super().observe(xp, memory, loads, signals)
        n, (position, velocity, *_) = self.count, memory.course
        return forces, [*own, position[n + 2], velocity[n + 2], velocity[n + 3]]

    def _leave_first(self, motion: Motion) -> Motion:
        """Return the motion without the first rotor."""
        n = self.count
        return Motion(*((*column[:n], *column[n + 2 :]) for column in motion))


@MECHANISMS.register("beam-harvester")
class BeamHarvester(BeamMotor):
    """Unbalanced motor on a beam with a piezoelectric patch and a resistor, and an optional wire."""

    typical_scenario = "beam_harvester"

    cites = ("kossoski2018", "erturk2011")

    piezo_coupling: Number = param("N/V", "coupling θ of first mode and patch", low=0.0, high=1e3, typical="2 mN/V")
    piezo_capacitance: Number = param("F", "capacitance C_p of the patch", above=0.0, high=1.0, typical="100 nF")
    load_resistance: Number = param("ohm", "resistance R_l that it feeds", above=0.0, high=1e12, typical="100 kohm")

    @override
    def coordinates(self) -> tuple[Coordinate, ...]:
        return (*super().coordinates(), Coordinate("flux", "V*s", "flux of the piezoelectric patch", "λ", 0.01))

    @override
    def rate_names(self) -> tuple[str, ...]:
        return *super().rate_names(), "piezo_voltage"

    @override
    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        first, *rest = super().demand(xp, motion, signals)
        voltage, change = motion.velocity[-1], motion.acceleration[-1]
        moved = self.piezo_coupling * motion.velocity[0]
        current = self.piezo_capacitance * change + voltage * (1.0 / self.load_resistance) + moved
        return [first - self.piezo_coupling * voltage, *rest, current]

    def energy(self, xp: Namespace, motion: Motion) -> MechanicalEnergy:
        """Return the energies including the charged patch, entered with the springs."""
        energy, voltage = super().energy(xp, motion), motion.velocity[-1]
        return energy._replace(springs=energy.springs + 0.5 * self.piezo_capacitance * voltage * voltage)

    @override
    def dissipative(self, xp: Namespace, motion: Motion) -> Column:
        return [*super().dissipative(xp, motion), motion.velocity[-1] * (1.0 / self.load_resistance)]

    @override
    def external_forces(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        return [*super().external_forces(xp, motion, signals), 0.0]

    @override
    def outputs(self) -> dict[str, Output]:
        return super().outputs() | {
            "piezo_voltage": Output("V", "voltage of the piezoelectric patch", "v"),
            "harvested_power": Output("W", "power in the resistor", "P_h"),
        }

    @override
    def convergence_scales(self) -> dict[str, float]:
        return super().convergence_scales() | {"piezo_voltage": 0.01}

    @override
    def observe(self, xp: Namespace, memory: MultibodyMemory, loads: Sequence[Load], signals: Column) -> Readout:
        forces, own = super().observe(xp, memory, loads, signals)
        voltage = memory.course.velocity[-1]
        return forces, [*own, voltage, voltage * voltage * (1.0 / self.load_resistance)]
