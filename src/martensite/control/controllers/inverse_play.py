"""Feed-forward by the inverse of a Prandtl–Ishlinskii hysteresis.

A slowly driven actuator is a static curve behind a sum of plays:

    y = N(w),    w = a_0 u + Σ a_i p_i(u),    p_i⁺ = max(u - r_i, min(u + r_i, p_i))

with the signal u and the output y. Both have an inverse; the inverse of the sum is a sum of plays, with thresholds and
weights in closed form:

    w = N⁻¹(r),    u_f = b_0 w + Σ b_i q_i(w)

N is piecewise linear between knots, and linear beyond them; two knots are a gain and an offset. A reference that is as
slow as the identified record is followed without hysteresis. Thermal lag, cooling rate, load and ambient temperature
are left to the feedback.

`martensite.control.synthesis.inverse_hysteresis` identifies the parameters from a slow record.

Sources: Kuhnen (2003), inverse; Krasnosel'skii and Pokrovskii (1989), plays.
"""

from itertools import accumulate, pairwise
from typing import Any

from martensite.base.errors import ParameterError
from martensite.base.parameters import part
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings
from martensite.control.controllers.pid import KEPT, Correction, PidMemory
from martensite.control.controllers.state_feedback import NumberedGains, as_row
from martensite.kernels.namespace import Namespace, Scalar


@CONTROLLERS.register("inverse-play")
class InversePlay(AbstractController):
    """Feed-forward by an inverse hysteresis of plays and a curve, with feedback."""

    cites = ("kuhnen2003", "krasnoselskii1989")
    integrals = (0,)

    thresholds: Any = part("thresholds r_1 < r_2 < … of the plays, in the unit of the signal", default=())
    weights: Any = part("weights a_0, a_1, …, one more than thresholds", default=(1.0,))
    knots: Any = part("levels of the sum of plays, rising", default=(0.0, 1.0))
    outputs: Any = part("readings at these levels, rising or falling, in SI", default=(0.0, 1.0))
    feedback: Correction = part("limits, and PID on the measured error", default=Correction())

    def check(self) -> None:
        for name in ("thresholds", "weights", "knots", "outputs"):
            self.__dict__[name] = as_row("inverse-play", name, self.__dict__[name])
        self._check_plays()
        x, y = self.knots.numbers, self.outputs.numbers
        steps = [b - a for a, b in pairwise(y)]
        rising = all(b > a for a, b in pairwise(x))
        turning = not (all(s > 0.0 for s in steps) or all(s < 0.0 for s in steps))
        if len(x) < 2 or len(x) != len(y) or not rising or turning:
            raise ParameterError(
                "The curve of controller `inverse-play` needs 2 or more rising `knots` and as many "
                f"`outputs` that all rise or all fall, but has knots {x} and outputs {y}."
            )

    def _check_plays(self) -> None:
        r, a = (0.0, *self.thresholds.numbers), self.weights.numbers
        slopes = list(accumulate(a))
        rising = all(after > before for before, after in pairwise(r))
        if len(a) != len(r) or not rising or min(slopes) <= 0.0:
            raise ParameterError(
                "The plays of controller `inverse-play` need rising `thresholds` above 0 and one of the `weights` "
                f"more, with sums a_0 + … + a_i above 0, but have thresholds {r[1:]} and weights {a}."
            )

    def describe(self, period: float) -> str:
        return self.feedback.describe(period)

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        idle = self.feedback.limit_signal(xp, 0.0)
        level = idle * sum(self.weights.numbers, 0.0)
        correction = self.feedback.rest(xp, reference, readings[self.measured])
        return [*correction, *[level] * len(self.thresholds.numbers)]

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        correction, plays = PidMemory(*memory[:KEPT]), memory[KEPT:]
        level = self._level(xp, reference)
        _, rows = _invert_plays(self.thresholds, self.weights)
        after = [xp.maximum(level - r, xp.minimum(level + r, q)) for (r, _), q in zip(rows, plays, strict=True)]
        feed, value = self._feed(xp, level, after), readings[self.measured]
        signal, correction = self.feedback.answer(xp, correction, feed, reference, value, dt)
        return signal, [*correction, *after]

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        correction, plays = PidMemory(*memory[:KEPT]), memory[KEPT:]
        feed = self._feed(xp, self._level(xp, reference), plays)
        return [*self.feedback.track(xp, correction, feed, signal, reference, readings[self.measured]), *plays]

    def _feed(self, xp: Namespace, level: Scalar, plays: Column) -> Scalar:
        first, rows = _invert_plays(self.thresholds, self.weights)
        signal = first * level
        for (_, b), q in zip(rows, plays, strict=True):
            signal = signal + b * q
        return self.feedback.limit_signal(xp, signal)

    def _level(self, xp: Namespace, output: Scalar) -> Scalar:
        """Return N⁻¹, the sum of plays at an output."""
        x, y = self.knots.numbers, self.outputs.numbers
        level = x[0] + (output - y[0]) * ((x[1] - x[0]) / (y[1] - y[0]))
        way = xp.where(y[1] > y[0], 1.0, -1.0)
        for k in range(1, len(x) - 1):
            here = x[k] + (output - y[k]) * ((x[k + 1] - x[k]) / (y[k + 1] - y[k]))
            level = xp.where(way * (output - y[k]) > 0.0, here, level)
        return level


def _invert_plays(thresholds: NumberedGains, weights: NumberedGains) -> tuple[Scalar, list[tuple[Scalar, Scalar]]]:
    """Return b_0, and threshold and weight of every play of the inverse (Kuhnen 2003)."""
    first, *others = weights.numbers
    slope, before, place = first, 0.0, 0.0
    rows: list[tuple[Scalar, Scalar]] = []
    for r, a in zip(thresholds.numbers, others, strict=True):
        place = place + slope * (r - before)
        rows.append((place, -a / (slope * (slope + a))))
        slope, before = slope + a, r
    return 1.0 / first, rows
