"""Controllers that switch between levels, and a controller that passes on its reference."""

from collections.abc import Mapping

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, option, param, text
from martensite.base.units import DIFFERENCE
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.base import DRIVE
from martensite.signals.levels import HIGH, MARGIN, TARGET_LEVEL


@CONTROLLERS.register("on-off")
class OnOff(AbstractController):
    """A switch that keeps a reading near its target.

        off if y ≥ r,     on if y < r - band,     else unchanged

    r is the reference, which may move. With a sensor delay t_d and a sample period T, a reading with rate v overshoots
    by about v (t_d + T).

    If the reading falls while the signal is on, choose `high` below `low`.
    """

    band: Number = param(DIFFERENCE, "distance below the target to switch on", low=0.0, default=0.0, typical=MARGIN)
    high: Number = param(DRIVE, "signal while it is on", typical=HIGH)
    low: Number = param(DRIVE, "signal while it is off", default=0.0)

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        return (0.0,)

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        value, (before,) = readings[self.measured], memory
        band_state = xp.where(value < reference, before, 0.0)
        on = xp.where(value < reference - self.band, 1.0, band_state)
        return xp.where(on > 0.5, self.high, self.low), (on,)


@CONTROLLERS.register("two-level")
class TwoLevel(AbstractController):
    """A relay with a full and a reduced level.

        u = u_H   if e ≥ φ
            u_L   if 0 < e < φ
            u_0   if e ≤ 0,            e = r - y

    Near the target the lower level reduces the oscillation of the relay. The switching has no memory and chatters at
    the sample rate. With `sign` = -1 the relay acts on -e: the second of two antagonistic elements gets the same
    controller with the other sign, and is off while the first is on.

    Source: variable structure control of Grant and Hayward (1997) for two antagonistic groups of fibres, where u_H and
    u_L are currents; original not seen.
    """

    cites = ("grant1997",)

    far: Number = param(DIFFERENCE, "error φ from which it is full", above=0.0, typical=MARGIN)
    high: Number = param(DRIVE, "signal u_H far from the target", typical=HIGH)
    near: Number = param(DRIVE, "signal u_L near the target", typical=TARGET_LEVEL)
    low: Number = param(DRIVE, "signal u_0 at the target and beyond", default=0.0)
    sign: str = option("sign of the error", "1", "-1", default="1")

    def check(self) -> None:
        least, most = sorted((self.low, self.high))
        if not least <= self.near <= most:
            raise ParameterError(
                f"The level `near` of a two-level relay must be between {least:g} and {most:g}, but is {self.near:g}."
            )

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        error = reference - readings[self.measured]
        error = error if self.sign == "1" else -error
        on = xp.where(error >= self.far, self.high, self.near)
        return xp.where(error > 0.0, on, self.low), ()


@CONTROLLERS.register("direct")
class Direct(AbstractController):
    """A line from the reference to the signal.

        u = K r + u_0

    It serves tests of a plant, records for identification, and comparisons with feedback. The reference has the unit of
    the signal; the limits are the limits of the source.
    """

    holds = False

    measured: str = text("name of a reading to compare with; it is not read", default="")
    gain: Number = param("1", "signal per reference", default=1.0)
    offset: Number = param(DRIVE, "signal without a reference", default=0.0)

    def reads(self) -> tuple[str, ...]:
        return ()

    def reference_unit(self, readings: Mapping[str, str], signal: str) -> str:
        return signal

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        return self.gain * reference + self.offset, ()
