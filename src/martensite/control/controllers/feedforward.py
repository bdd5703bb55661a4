"""Feed-forward by a model run beside the plant and inverted in every sample.

The controller carries a model and its state. In a sample it advances the model under the signal of the sample before.
Then it finds the signal u_f, held for a time L, under which the output of the model reaches the future reference:

    y(t + L; x(t), u_f) = r(t) + c ṙ(t) L,      low ≤ u_f ≤ high

by bracketed Newton iterations of fixed count with exact slopes. Out of reach, it is the limit that comes nearest: also
where the output does not answer in that time at all, as on the way from one branch of a hysteresis to the other; at
the reference, it is then the idle signal. Hysteresis, latent heat and the slow cooling are inverted with everything
else the model knows, for it is the model itself that is solved; the error of the model is left to the feedback. A
reference that the model can never reach keeps the signal at the limit; a supervisor must detect this.

The error of the output goes like exp(-t/L): a short L follows closely and moves the signal much, and with inertia it
must be no shorter than the plant takes to answer. Of the reference only the present value is known: its rate ṙ is its
change per sample through a first-order filter. A reference that jumps has none: take c = 0 for it.

The model goes along under u_f alone, so that feedback corrects what the model does not know
without being taken back by it.

Source: inversion of a model as feed-forward, Devasia, Chen and Paden 1996; here over one step of
the horizon instead of the whole trajectory.
"""

from typing import Any, NamedTuple

from martensite.actuators.assembly import AbstractSystem, advance_steps
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Number, option, param, part, text
from martensite.base.units import DIFFERENCE
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings
from martensite.control.controllers.pid import KEPT, Correction, PidMemory
from martensite.kernels import floats
from martensite.kernels.bracketed_newton import solve_bracketed
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, flatten_numbers

SLIGHT = 1e-9
"""Slope added to the output over its range, so that a flat model has an answer: the last one."""
INSIDE = 0.05, 0.95
"""First guesses, as fractions of the range between the limits: inside the range, because slopes may vanish at its ends.
"""


class Following(NamedTuple):
    """Memory of a feed-forward beside the state of its model."""

    feed: Scalar
    """u_f, the signal of the sample before."""
    before: Scalar
    """Reference of the sample before."""
    rate: Scalar
    """Filtered rate of the reference [1/s]."""
    correction: PidMemory


@CONTROLLERS.register("feedforward")
class Feedforward(AbstractController):
    """The signal with which a model follows the reference, and feedback for what it misses."""

    cites = ("devasia1996",)
    integrals = (-KEPT,)

    model: AbstractSystem = part("the plant as it is believed to be, with one drive")
    output: str = text("output of the model that follows; empty: named as measured", default="")
    lookahead: Number = param("s", "time L after which the model shall be there", above=0.0, default=0.1)
    slope_weight: Number = param("1", "share c of the reference's rate looked ahead", low=0.0, high=1.0, default=1.0)
    filter: Number = param("s", "time constant of the filter of that rate", low=0.0, default=0.05)
    sense: str = option("whether the output rises or falls with the signal", "rising", "falling", default="rising")
    slack: Number = param(DIFFERENCE, "least answer of the model in the time L that is one", above=0.0, default=1e-6)
    substeps: int = part("steps of the model in a sample", default=1)
    ahead: int = part("steps of the model in the time L", default=1)
    iterations: int = part("Newton iterations for the signal", default=8)
    feedback: Correction = part("limits, and PID on the measured error", default=Correction())

    def check(self) -> None:
        """Raise `ParameterError` if the model does not fit; keep what its state looks like."""
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
        """Return the steps of the model and iterations."""
        return self.substeps, self.ahead, self.iterations

    @property
    def followed_output(self) -> str:
        """Return the output of the model that follows the reference."""
        return self.output or self.measured

    def describe(self, period: float) -> str:
        """Return the anti-windup of the feedback, in words."""
        return self.feedback.describe(period)

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        """Return the model at rest under the idle signal."""
        idle = self.feedback.limit_signal(xp, 0.0)
        correction = self.feedback.rest(xp, reference, readings[self.measured])
        state = self.model.init(xp, idle)
        return flatten_numbers((state, Following(idle, reference, 0.0, correction)))

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        """Return the signal of this sample, and the memory for the next sample."""
        state, held = self._nest_memory.rebuild(memory)
        some = dt > 0.0
        length = xp.where(some, dt, self.lookahead)
        after = self._after(xp, state, held.feed, length, self.substeps)
        rows = zip(flatten_numbers(after), flatten_numbers(state), strict=True)
        state = NestedShape(state).rebuild([xp.where(some, new, old) for new, old in rows])
        rate = self._rate(held, reference, length)
        target = reference + self.slope_weight * rate * self.lookahead
        feed = self._solve_signal(xp, state, target, held.feed)
        found = readings[self.measured]
        correct = self.feedback.answer
        signal, correction = correct(xp, held.correction, feed, reference, found, dt)
        return signal, flatten_numbers((state, Following(feed, reference, rate, correction)))

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        """With the integral of the feedback that gives the signal."""
        held, found = self._nest_memory.rebuild(memory)[1], readings[self.measured]
        return [*memory[:-KEPT], *self.feedback.track(xp, held.correction, held.feed, signal, reference, found)]

    @property
    def _nest_memory(self) -> NestedShape:
        memory = PidMemory(*[0.0] * KEPT)
        return NestedShape((self.__dict__["_rest"], Following(0.0, 0.0, 0.0, memory)))

    def _rate(self, held: Following, reference: Scalar, length: Scalar) -> Scalar:
        change = reference - held.before - held.rate * length
        return held.rate + change / (self.filter + length)

    def _after(self, xp: Namespace, state: Any, signal: Scalar, length: Scalar, steps: int) -> Any:
        after, _ = advance_steps(xp, self.model, state, [((signal,), length / steps)], steps)
        return after

    def _solve_signal(self, xp: Namespace, state: Any, target: Scalar, before: Scalar) -> Scalar:
        """Return the signal that gets the output of the model to the target."""
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

        found = solve_bracketed(xp, beyond, xp.clip(last, *INSIDE), (0.0, 1.0), self.iterations)
        solved = xp.where(gap <= 0.0, 0.0, xp.where(gap >= span, 1.0, found))
        signal = law.low + solved * (law.high - law.low)
        away = xp.where(gap > self.slack, law.high, xp.where(gap < -self.slack, law.low, idle))
        return xp.where(some, signal, away)
