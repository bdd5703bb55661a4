"""Feed-forward by a model of the plant that is inverted in every sample.

In a sample the model advances under the signal of the last sample. Then the controller solves for the signal u_f, held
for a time L, under which the output of the model reaches the future reference:

    y(t + L; x(t), u_f) = r(t) + c ṙ(t) L,      low ≤ u_f ≤ high

by bracketed Newton iterations of fixed count with exact slopes. If the reference is out of reach, u_f is the nearer
limit, also where the output does not react within L, as between the branches of a hysteresis. If such an output is at
the reference, u_f is the idle signal. The model includes hysteresis, latent heat and slow cooling; feedback
corrects the error of the model. A reference that the model can never reach keeps the signal at the limit, which a
supervisor must detect.

The error of the output decays like exp(-t/L): a short L follows closely with large changes of the signal. With inertia
L must be at least the response time of the plant. The rate ṙ is the filtered change of the reference per sample. Use
c = 0 for a reference with jumps.

The model advances under u_f alone, so that it does not counteract the feedback.

Source: feed-forward by inversion of a model, Devasia, Chen and Paden (1996), here over one step of the horizon instead
of the whole trajectory.
"""

from typing import Any, NamedTuple

from martensite.actuators.assembly import AbstractSystem, advance_steps
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Number, option, param, part, text
from martensite.base.units import DIFFERENCE
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings
from martensite.control.controllers.pid import KEPT, NO_MEMORY, Correction, PidMemory
from martensite.kernels import floats
from martensite.kernels.bracketed_newton import solve_bracketed
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers

SLIGHT = 1e-9
"""Slope added to the output over its range, so that a flat model keeps the last signal."""
INSIDE = 0.05, 0.95
"""First guesses as fractions of the range of the signal, away from the ends, where slopes may vanish."""


class FeedforwardMemory(NamedTuple):
    """Memory of a feed-forward, in addition to the state of its model."""

    feed: Scalar
    """u_f of the last sample."""
    before: Scalar
    """Reference of the last sample."""
    rate: Scalar
    """Filtered rate of the reference [1/s]."""
    correction: PidMemory


@CONTROLLERS.register("feedforward")
class Feedforward(AbstractController):
    """Feed-forward by inversion of a model, with feedback."""

    cites = ("devasia1996",)
    integrals = (-KEPT,)

    model: AbstractSystem = part("model of the plant, with one drive")
    output: str = text("output of the model that follows the reference; default: named as measured", default="")
    lookahead: Number = param("s", "time L in which the model must reach the reference", above=0.0, default=0.1)
    slope_weight: Number = param("1", "weight c of the rate of the reference", low=0.0, high=1.0, default=1.0)
    filter: Number = param("s", "time constant of the filter of that rate", low=0.0, default=0.05)
    sense: str = option("whether the output rises or falls with the signal", "rising", "falling", default="rising")
    slack: Number = param(DIFFERENCE, "change of the output in the time L that counts as zero", above=0.0, default=1e-6)
    substeps: int = part("steps of the model in a sample", default=1)
    ahead: int = part("steps of the model in the time L", default=1)
    iterations: int = part("Newton iterations for the signal", default=8)
    feedback: Correction = part("limits, and PID on the measured error", default=Correction())

    def check(self) -> None:
        drives, outputs = self.model.drives(), self.model.outputs()
        if len(drives) != 1:
            raise ParameterError(
                f"The model of controller `feedforward` must have one drive, but has "
                f"{', '.join(drive.name for drive in drives) or 'none'}."
            )
        if self.followed_output not in outputs:
            raise ParameterError(
                f"The model of controller `feedforward` has no output `{self.followed_output}`. "
                f"{suggest_name(self.followed_output, outputs)}"
            )
        for name in ("substeps", "ahead", "iterations"):
            count = self.__dict__[name]
            if not isinstance(count, int) or count < 1:
                raise ParameterError(f"`{name}` of `feedforward` must be a whole number above 0, but is {count!r}.")
        self.__dict__["_rest"] = self.model.init(floats, self.feedback.law.idle)

    def layout(self) -> tuple[int, ...]:
        return self.substeps, self.ahead, self.iterations

    @property
    def followed_output(self) -> str:
        """Return the output of the model that follows the reference."""
        return self.output or self.measured

    def describe(self, period: float) -> str:
        return self.feedback.describe(period)

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        idle = self.feedback.limit_signal(xp, 0.0)
        correction = self.feedback.rest(xp, reference, readings[self.measured])
        state = self.model.init(xp, idle)
        return flatten_numbers((state, FeedforwardMemory(idle, reference, 0.0, correction)))

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        state, before = self._nest_memory.rebuild(memory)
        some = dt > 0.0
        length = xp.where(some, dt, self.lookahead)
        after = self._after(xp, state, before.feed, length, self.substeps)
        rows = zip(flatten_numbers(after), flatten_numbers(state), strict=True)
        state = NestedShape(state).rebuild([xp.where(some, new, old) for new, old in rows])
        rate = self._rate(before, reference, length)
        target = reference + self.slope_weight * rate * self.lookahead
        feed = self._solve_signal(xp, state, target, before.feed)
        value = readings[self.measured]
        signal, correction = self.feedback.answer(xp, before.correction, feed, reference, value, dt)
        return signal, flatten_numbers((state, FeedforwardMemory(feed, reference, rate, correction)))

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        before, value = self._nest_memory.rebuild(memory)[1], readings[self.measured]
        return [*memory[:-KEPT], *self.feedback.track(xp, before.correction, before.feed, signal, reference, value)]

    @property
    def _nest_memory(self) -> NestedShape:
        return NestedShape((self.__dict__["_rest"], FeedforwardMemory(0.0, 0.0, 0.0, NO_MEMORY)))

    def _rate(self, before: FeedforwardMemory, reference: Scalar, length: Scalar) -> Scalar:
        change = reference - before.before - before.rate * length
        return before.rate + change / (self.filter + length)

    def _after(self, xp: Namespace, state: Any, signal: Scalar, length: Scalar, steps: int) -> Any:
        after, _ = advance_steps(xp, self.model, state, [((signal,), length / steps)], steps)
        return after

    def _solve_signal(self, xp: Namespace, state: Any, target: Scalar, before: Scalar) -> Scalar:
        law, place = self.feedback.law, list(self.model.outputs()).index(self.followed_output)
        idle = self.feedback.limit_signal(xp, 0.0)

        def output(xp: Namespace, share: Scalar) -> Scalar:
            signal = law.low + share * (law.high - law.low)
            after = self._after(xp, state, signal, self.lookahead, self.ahead)
            return self.model.observe(xp, after, signal)[place]

        least, most = output(xp, 0.0), output(xp, 1.0)
        way = 1.0 if self.sense == "rising" else -1.0
        reach, gap = way * (most - least), way * (target - least)
        some = reach > self.slack
        span = xp.where(some, reach, 1.0)
        last = (before - law.low) / (law.high - law.low)

        def beyond(xp: Namespace, share: Scalar) -> Scalar:
            return way * (output(xp, share) - target) / span + SLIGHT * (share - last)

        root = solve_bracketed(xp, beyond, xp.clip(last, *INSIDE), (0.0, 1.0), self.iterations)
        solved = xp.where(gap <= 0.0, 0.0, xp.where(gap >= span, 1.0, root))
        signal = law.low + solved * (law.high - law.low)
        away = xp.where(gap > self.slack, law.high, xp.where(gap < -self.slack, law.low, idle))
        return xp.where(some, signal, away)
