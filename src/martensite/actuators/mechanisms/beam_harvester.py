r"""The motor on a beam, with a piezoelectric patch on the beam that feeds a resistor: power from the Sommerfeld effect.

To the equations of `beam-motor` the patch adds, on the first mode of the beam q and with its voltage v,

    … + k q - θ v = …,        C_p v' + v/R_l + θ q' = 0.

v is the rate of the last coordinate, the flux λ = ∫ v dt. What the beam gives, -θ v q', is the power v²/R_l in the
resistor but for the charge of the patch, ½ C_p v², which is entered with the springs. Harmonic in q, V = -iωθR_l Q/(1 +
iωR_lC_p): without load, R_l → ∞, the patch stiffens the beam by θ²/C_p.

The patch stretches with the curvature near the clamp; to the higher modes it is not coupled here. Source: Erturk and
Inman (2011), the lumped form of chapter 3; Kossoski (2018), section 6.3, leaves energy harvesting for later.
"""

from collections.abc import Sequence

from martensite.actuators.mechanics.motion import Motion
from martensite.actuators.mechanisms.base import MECHANISMS, Column, Load, MechanicalEnergy, Output, Readout
from martensite.actuators.mechanisms.beam_motor import BeamMotor
from martensite.actuators.mechanisms.multibody import Assembled, Coordinate
from martensite.base.parameters import param
from martensite.kernels.namespace import Namespace, Scalar


@MECHANISMS.register("beam-harvester")
class BeamHarvester(BeamMotor):
    """An unbalanced motor on a beam with a piezoelectric patch and a resistor, and a wire if it is wanted."""

    typical_scenario = "beam_harvester"

    cites = ("kossoski2018", "erturk2011")

    piezo_coupling: Scalar = param("N/V", "coupling θ of first mode and patch", low=0.0, high=1e3, typical="2 mN/V")
    piezo_capacitance: Scalar = param("F", "capacitance C_p of the patch", above=0.0, high=1.0, typical="100 nF")
    load_resistance: Scalar = param("ohm", "resistance R_l that it feeds", above=0.0, high=1e12, typical="100 kohm")

    def coordinates(self) -> tuple[Coordinate, ...]:
        """Those of the beam with its motor, and the flux of the patch."""
        return (*super().coordinates(), Coordinate("flux", "V*s", "flux of the piezoelectric patch", "λ", 0.01))

    def demand(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        """As without a patch, and the current [A] of that."""
        first, *rest = super().demand(xp, motion, signals)
        voltage, change = motion.velocity[-1], motion.acceleration[-1]
        moved = self.piezo_coupling * motion.velocity[0]
        current = self.piezo_capacitance * change + voltage * (1.0 / self.load_resistance) + moved
        return [first - self.piezo_coupling * voltage, *rest, current]

    def energy(self, xp: Namespace, motion: Motion) -> MechanicalEnergy:
        """With that of the charged patch, which is entered with the springs."""
        found, voltage = super().energy(xp, motion), motion.velocity[-1]
        return found._replace(springs=found.springs + 0.5 * self.piezo_capacitance * voltage * voltage)

    def dissipative(self, xp: Namespace, motion: Motion) -> Column:
        """With the current through the resistor [A]."""
        return [*super().dissipative(xp, motion), motion.velocity[-1] * (1.0 / self.load_resistance)]

    def external_forces(self, xp: Namespace, motion: Motion, signals: Column) -> Column:
        """The voltage of the motor [V]."""
        return [*super().external_forces(xp, motion, signals), 0.0]

    def outputs(self) -> dict[str, Output]:
        """With voltage and power of the resistor."""
        return super().outputs() | {
            "piezo_voltage": Output("V", "voltage of the piezoelectric patch", "v"),
            "harvested_power": Output("W", "power in the resistor", "P_h"),
        }

    def convergence_scales(self) -> dict[str, float]:
        """With the voltage of the patch."""
        return super().convergence_scales() | {"piezo_voltage": 0.01}

    def observe(self, xp: Namespace, memory: Assembled, loads: Sequence[Load], signals: Column) -> Readout:
        """As without a patch, with its voltage and power."""
        forces, found = super().observe(xp, memory, loads, signals)
        voltage = memory.course.velocity[-1]
        return forces, [*found, voltage, voltage * voltage * (1.0 / self.load_resistance)]
