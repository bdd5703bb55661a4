"""Resistance meter: the element measures itself, by the voltage and the current that heat it.

    R = U/I,    reading = R + √(ρ² R² + σ²) n    if |I| ≥ I_min,    else as before

U is the voltage across the element, I the current through it, with four wires: R excludes the leads. Where the current
is below I_min nothing can be measured, and the sensor gives no new reading: on a bench, the last reading gets older.
Before the first reading, the output is R_0. For a switched source, U and I are rms values of a period, whose ratio is
the resistance as well.

ρ is the noise as a share of the reading; its default of 1 % and that of I_min are assumed.
"""

from martensite.base.parameters import Number, param
from martensite.control.sensors.base import SENSORS, AbstractSensor, Column
from martensite.kernels.namespace import Flag, Namespace, Scalar


@SENSORS.register("resistance")
class ResistanceSensor(AbstractSensor):
    """Resistance from voltage and current, while there is a current."""

    unit = "ohm"
    sees = ("voltage", "current")

    relative_noise: Number = param("1", "standard deviation of a reading as a share of it", low=0.0, default=0.01)
    noise: Number = param("ohm", "standard deviation whatever it reads", low=0.0, default=0.0)
    resolution: Number = param("ohm", "least step of a reading", low=0.0, default=0.0)
    least_current: Number = param("A", "current below which there is nothing to measure", above=0.0, default=0.01)
    first: Number = param("ohm", "what it says before it has measured", low=0.0, default=0.0)

    def valid(self, xp: Namespace, truth: Column) -> Flag:
        """Return whether the current is large enough."""
        return xp.abs(truth[1]) >= self.least_current

    def rest(self, xp: Namespace, truth: Column) -> Column:
        """Return the reading without a current."""
        return (xp.where(self.valid(xp, truth), self._ratio(xp, truth), self.first),)

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        """Return the resistance with noise [ohm], or the last one."""
        ratio, own = self._ratio(xp, truth), self.relative_noise
        size = xp.sqrt(own * own * ratio * ratio + self.noise * self.noise)
        value = xp.where(self.valid(xp, truth), ratio + size * noise, state[0])
        return value, (value,)

    def _ratio(self, xp: Namespace, truth: Column) -> Scalar:
        voltage, current = truth
        return voltage / xp.where(self.valid(xp, truth), current, 1.0)
