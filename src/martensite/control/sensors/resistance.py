"""Resistance meter: the element as its own sensor, by its voltage and current.

    R = U/I,    reading = R + √(ρ² R² + σ²) n    if |I| ≥ I_min,    else unchanged

U is the voltage across the element, I the current through it, with four wires: R excludes the leads. Below I_min the
resistance cannot be measured, and the last reading ages. Before the first measurement the reading is R_0. For a
switched source, U and I are rms values of a period; their ratio is also the resistance.

ρ is the noise as a fraction of the reading; its default of 1 % and the default of I_min are assumed.
"""

from martensite.base.parameters import Number, param
from martensite.control.sensors.base import SENSORS, AbstractSensor, Column
from martensite.kernels.namespace import Flag, Namespace, Scalar


@SENSORS.register("resistance")
class ResistanceSensor(AbstractSensor):
    """Resistance from voltage and current, while a current flows."""

    unit = "ohm"
    sees = ("voltage", "current")

    relative_noise: Number = param("1", "standard deviation of a reading over the reading", low=0.0, default=0.01)
    noise: Number = param("ohm", "standard deviation that is independent of the reading", low=0.0, default=0.0)
    resolution: Number = param("ohm", "least step of a reading", low=0.0, default=0.0)
    least_current: Number = param("A", "current below which the resistance cannot be measured", above=0.0, default=0.01)
    first: Number = param("ohm", "reading before the first measurement", low=0.0, default=0.0)

    def valid(self, xp: Namespace, truth: Column) -> Flag:
        return xp.abs(truth[1]) >= self.least_current

    def rest(self, xp: Namespace, truth: Column) -> Column:
        return (xp.where(self.valid(xp, truth), self._ratio(xp, truth), self.first),)

    def step(self, xp: Namespace, state: Column, truth: Column, noise: Scalar, dt: Scalar) -> tuple[Scalar, Column]:
        ratio, relative = self._ratio(xp, truth), self.relative_noise
        size = xp.sqrt(relative * relative * ratio * ratio + self.noise * self.noise)
        value = xp.where(self.valid(xp, truth), ratio + size * noise, state[0])
        return value, (value,)

    def _ratio(self, xp: Namespace, truth: Column) -> Scalar:
        voltage, current = truth
        return voltage / xp.where(self.valid(xp, truth), current, 1.0)
