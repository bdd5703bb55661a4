"""PID controller with a schedule of gains, which may differ for rising and falling references.

    K(σ) = K_j + (K_j+1 - K_j) (σ - σ_j)/(σ_j+1 - σ_j)       between two points of a table,

and constant beyond the table, for K_p, K_i and K_d, where σ is the reference or any reading. With two tables, `rising`
applies after the reference has risen and `falling` after it has fallen; before its first move the sign of the error
decides. The error itself would change sign with noise. If the signal raises the reading, falling is cooling, whose rate
no signal can increase.

The integral is a signal, not a sum of errors, so that a change of K_i causes no jump. With `gain_change = "bumpless"`
changes of K_p and K_d cause no jump either: the integral, if any, takes the step,

    I = I_k-1 + (K_p' - K_p) (b r_k-1 - y_k-1) + (K_d' - K_d) D_k-1,        primes: gains of the last sample

The law is in `martensite.control.controllers.pid`.
"""

import math
from itertools import pairwise
from typing import NamedTuple

from martensite.actuators.assembly import Members
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, Parametrised, option, param, part, text
from martensite.base.units import DERIVATIVE_GAIN, GAIN, INTEGRAL_GAIN, LEVEL
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings
from martensite.control.controllers.pid import GAINS_ARE, IN_SECONDS, PER_SAMPLE, Gains, PidLaw, PidMemory
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.signals.levels import HIGH


class GainsAt(Parametrised):
    """Gains at a point of the schedule."""

    at: Number = param(LEVEL, "value of the reference or of the reading", typical=HIGH)
    Kp: Number = param(GAIN, "proportional gain", typical=100.0)
    Ki: Number = param(INTEGRAL_GAIN, "integral gain", default=0.0)
    Kd: Number = param(DERIVATIVE_GAIN, "derivative gain", default=0.0)


class GainSchedule(Members[GainsAt], init=False):
    """Gains by named points, in ascending order."""

    noun, kind = "point", GainsAt

    def __init__(self, **members: GainsAt) -> None:
        super().__init__(**members)
        places = [one.at for one in self.members().values()]
        if not places:
            raise ParameterError("A schedule of gains needs at least one point; none given.")
        for before, after in pairwise(places):
            if not before < after:
                raise ParameterError(
                    f"The points of a schedule of gains must ascend, but {after:g} comes after {before:g}."
                )

    def gains(self, xp: Namespace, at: Scalar) -> Gains:
        """Return the gains at a value by linear interpolation."""
        points = list(self.members().values())
        first = points[0]
        gains = Gains(first.Kp, first.Ki, first.Kd)
        for a, b in pairwise(points):
            fraction = xp.clip((at - a.at) / (b.at - a.at), 0.0, 1.0)
            steps = (b.Kp - a.Kp, b.Ki - a.Ki, b.Kd - a.Kd)
            gains = Gains(*(k + fraction * step for k, step in zip(gains, steps, strict=True)))
        return gains


class ScheduledMemory(NamedTuple):
    """Memory of a scheduled PID controller."""

    integral: Scalar
    before: Scalar
    change: Scalar
    reference: Scalar
    direction: Scalar
    """1 after the reference rose, -1 after it fell."""


SCHEDULED = len(ScheduledMemory._fields)


class BumplessMemory(NamedTuple):
    """Additional memory for a bumpless change of gains."""

    Kp: Scalar
    Kd: Scalar
    proportional: Scalar
    """b r - y of the last sample."""


@CONTROLLERS.register("scheduled-pid")
class ScheduledPid(AbstractController):
    """A PID controller with scheduled gains for rising and falling references."""

    cites = ("copaci2019",)
    names_reading = ("over", "measured")
    integrals = (0,)

    over: str = text("name of the reading that selects the gains; default: the reference", default="")
    rising: GainSchedule = part(
        "gains since the reference rose", typical={"low": {"at": "1 mm", "Kp": 100}, "high": {"at": "5 mm", "Kp": 100}}
    )
    falling: GainSchedule | None = part("gains since the reference fell; default: as rising", default=None)
    gains_are: str = option(
        "gains of K_p + K_i/s + K_d s, or K_i and K_d of the discrete form C(z)", *GAINS_ARE, default=IN_SECONDS
    )
    gain_change: str = option(
        "change of gains: steps the signal (direct), or the integral takes the step",
        "direct",
        "bumpless",
        default="direct",
    )
    law: PidLaw = part("limits, set-point weights, filter and anti-windup", default=PidLaw())

    def describe(self, period: float) -> str:
        first = self.rising.gains(floats, -math.inf)
        return self.law.describe(first, period, self.gains_are == PER_SAMPLE)

    def reads(self) -> tuple[str, ...]:
        return (self.measured, self.over) if self.over else (self.measured,)

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        value = readings[self.measured]
        direction = xp.where(reference < value, -1.0, 1.0)
        state = ScheduledMemory(*self.law.rest(xp, reference, value), reference, direction)
        if self.gain_change == "direct":
            return state
        gains = self._gains(xp, readings[self.over] if self.over else reference, direction)
        return (*state, *BumplessMemory(gains.Kp, gains.Kd, self.law.weight * reference - value))

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        before = ScheduledMemory(*memory[:SCHEDULED])
        unchanged = xp.where(reference < before.reference, -1.0, before.direction)
        direction = xp.where(reference > before.reference, 1.0, unchanged)
        at = readings[self.over] if self.over else reference
        gains, sampled = self._gains(xp, at, direction), self.gains_are == PER_SAMPLE
        value, pid = readings[self.measured], PidMemory(*before[:3])
        if self.gain_change == "bumpless":
            pid = self._take_step(xp, gains, pid, BumplessMemory(*memory[SCHEDULED:]))
        signal, after = self.law.answer(xp, gains, pid, reference, value, dt, sampled)
        state = ScheduledMemory(*after, reference, direction)
        if self.gain_change == "direct":
            return signal, state
        return signal, (*state, *BumplessMemory(gains.Kp, gains.Kd, self.law.weight * reference - value))

    def _take_step(self, xp: Namespace, gains: Gains, pid: PidMemory, last: BumplessMemory) -> PidMemory:
        """Return the memory whose integral, if any, takes the step of a change of gains."""
        step = (last.Kp - gains.Kp) * last.proportional + (last.Kd - gains.Kd) * pid.change
        return pid._replace(integral=pid.integral + xp.where(xp.abs(gains.Ki) > 0.0, step, 0.0))

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        state = ScheduledMemory(*memory[:SCHEDULED])
        gains = self._gains(xp, readings[self.over] if self.over else reference, state.direction)
        pid = self.law.track(xp, gains, PidMemory(*memory[:3]), signal, reference, readings[self.measured])
        return (*state._replace(integral=pid.integral), *memory[SCHEDULED:])

    def _gains(self, xp: Namespace, at: Scalar, direction: Scalar) -> Gains:
        up = self.rising.gains(xp, at)
        if self.falling is None:
            return up
        down = self.falling.gains(xp, at)
        pairs = zip(up, down, strict=True)
        return Gains(*(xp.where(direction > 0.0, a, b) for a, b in pairs))
