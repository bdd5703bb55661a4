"""A PID controller whose gains follow a schedule, others rising than falling.

    K(σ) = K_j + (K_j+1 - K_j) (σ - σ_j)/(σ_j+1 - σ_j)       between two points of a table,

and the nearest point beyond them, for K_p, K_i and K_d alike, where σ is the reference or any reading: a plant whose
gain changes over its stroke gets a loop that does not. With two tables, `rising` counts from where the reference last
rose and `falling` from where it last fell; before it has ever moved, the sign of the first error decides. It is the
reference that decides and not the error, whose sign changes with every noise about the target. If the signal raises
what is measured, rising is heating and falling is cooling, whose rate no signal can help.

The integral is a signal, not a sum of errors, so that nothing jumps with K_i. With `gain_change = "bumpless"` nothing
jumps with K_p and K_d either: the integral, if there is one, takes the step that other gains would make,

    I = I_k-1 + (K_p' - K_p) (b r_k-1 - y_k-1) + (K_d' - K_d) D_k-1,        gains of the last sample with a prime

Equation, limits and anti-windup are those of `martensite.control.controllers.pid`.
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

    at: Number = param(LEVEL, "where: value of the reference or of the reading", typical=HIGH)
    Kp: Number = param(GAIN, "proportional gain", typical=100.0)
    Ki: Number = param(INTEGRAL_GAIN, "integral gain", default=0.0)
    Kd: Number = param(DERIVATIVE_GAIN, "derivative gain", default=0.0)


class GainSchedule(Members[GainsAt], init=False):
    """Gains over what decides about them, by names of points, in ascending order."""

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
        """Return the gains at a value, piecewise linear."""
        points = list(self.members().values())
        first = points[0]
        found = Gains(first.Kp, first.Ki, first.Kd)
        for a, b in pairwise(points):
            share = xp.clip((at - a.at) / (b.at - a.at), 0.0, 1.0)
            steps = (b.Kp - a.Kp, b.Ki - a.Ki, b.Kd - a.Kd)
            found = Gains(*(k + share * step for k, step in zip(found, steps, strict=True)))
        return found


class ScheduledMemory(NamedTuple):
    """Memory of a scheduled PID controller."""

    integral: Scalar
    before: Scalar
    change: Scalar
    """Filtered change, as in `PidMemory`."""
    reference: Scalar
    """Reference of the last sample."""
    direction: Scalar
    """1 since the reference rose, -1 since it fell."""


SCHEDULED = len(ScheduledMemory._fields)


class BumplessMemory(NamedTuple):
    """Additional memory that prevents a step of the signal when the gains change."""

    Kp: Scalar
    Kd: Scalar
    proportional: Scalar
    """b r - y of the last sample."""


@CONTROLLERS.register("scheduled-pid")
class ScheduledPid(AbstractController):
    """A PID controller with gains over a reading or the reference, rising and falling."""

    cites = ("copaci2019",)
    names_reading = ("over", "measured")
    integrals = (0,)

    over: str = text("name of the reading that decides; the reference if none", default="")
    rising: GainSchedule = part(
        "gains since the reference rose", typical={"low": {"at": "1 mm", "Kp": 100}, "high": {"at": "5 mm", "Kp": 100}}
    )
    falling: GainSchedule | None = part("gains since it fell; as rising if none", default=None)
    gains_are: str = option(
        "gains of K_p + K_i/s + K_d s, or K_i and K_d of the discrete form C(z)", *GAINS_ARE, default=IN_SECONDS
    )
    gain_change: str = option(
        "whether a change of gains steps the signal, or the integral takes the step",
        "direct",
        "bumpless",
        default="direct",
    )
    law: PidLaw = part("limits, set-point weights, filter and anti-windup", default=PidLaw())

    def describe(self, period: float) -> str:
        """Return the anti-windup, and filter for the gains of the first point, in words."""
        first = self.rising.gains(floats, -math.inf)
        return self.law.describe(first, period, self.gains_are == PER_SAMPLE)

    def reads(self) -> tuple[str, ...]:
        """Return the controlled reading and the reading that selects the gains."""
        return (self.measured, self.over) if self.over else (self.measured,)

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        """Nothing integrated, in the direction of the error."""
        value = readings[self.measured]
        direction = xp.where(reference < value, -1.0, 1.0)
        held = ScheduledMemory(*self.law.rest(xp, reference, value), reference, direction)
        if self.gain_change == "direct":
            return held
        gains = self._gains(xp, readings[self.over] if self.over else reference, direction)
        return (*held, *BumplessMemory(gains.Kp, gains.Kd, self.law.weight * reference - value))

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        """Return the signal of this sample, and the memory for the next sample."""
        before = ScheduledMemory(*memory[:SCHEDULED])
        kept = xp.where(reference < before.reference, -1.0, before.direction)
        direction = xp.where(reference > before.reference, 1.0, kept)
        at = readings[self.over] if self.over else reference
        gains, sampled = self._gains(xp, at, direction), self.gains_are == PER_SAMPLE
        value, held = readings[self.measured], PidMemory(*before[:3])
        if self.gain_change == "bumpless":
            held = self._take_step(xp, gains, held, BumplessMemory(*memory[SCHEDULED:]))
        signal, after = self.law.answer(xp, gains, held, reference, value, dt, sampled)
        found = ScheduledMemory(*after, reference, direction)
        if self.gain_change == "direct":
            return signal, found
        return signal, (*found, *BumplessMemory(gains.Kp, gains.Kd, self.law.weight * reference - value))

    def _take_step(self, xp: Namespace, gains: Gains, held: PidMemory, last: BumplessMemory) -> PidMemory:
        """With an integral, if there is one, that takes up what other gains change in the signal of the last sample."""
        step = (last.Kp - gains.Kp) * last.proportional + (last.Kd - gains.Kd) * held.change
        return held._replace(integral=held.integral + xp.where(xp.abs(gains.Ki) > 0.0, step, 0.0))

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        """With the integral that gives the signal."""
        held = ScheduledMemory(*memory[:SCHEDULED])
        gains = self._gains(xp, readings[self.over] if self.over else reference, held.direction)
        pid = self.law.track(xp, gains, PidMemory(*memory[:3]), signal, reference, readings[self.measured])
        return (*held._replace(integral=pid.integral), *memory[SCHEDULED:])

    def _gains(self, xp: Namespace, at: Scalar, direction: Scalar) -> Gains:
        """Return the given gains for a direction."""
        up = self.rising.gains(xp, at)
        if self.falling is None:
            return up
        down = self.falling.gains(xp, at)
        pairs = zip(up, down, strict=True)
        return Gains(*(xp.where(direction > 0.0, a, b) for a, b in pairs))
