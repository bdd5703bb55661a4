"""Memory of a controller that learns along a repeated task.

    w_j(k) = v_j(k) + g e_j(k + λ)
    v_j+1(k) = (1 - φ) Σ_i c_i w_j(k + i),       c_i = C(2 h, h + i)/4^h,   i = -h … h

v_j(k) is the signal learned by repetition j at the points k = 0 … N - 1 of the task, and e the error. The lead λ
compensates for the delay of the plant. The binomial weights c are a zero-phase filter Q, which passes cos^2h(ω/2) at ω
per point and removes what the plant cannot follow. The fraction φ is forgotten in every repetition. Between points v
is linear in time; errors are sampled at the points.

The memory is a line that moves by one place at every point: future values, values of the last points, and values that
wait for their neighbours to be smoothed. Repetitions follow without a gap.

Learning stops if it diverges: if the rms error has risen by more than 2 % in `PATIENCE` successive repetitions, and by
more than the factor `growth` in total. Then the learned signal is no longer used. After a change of the plant the
error jumps once and is learned away, so that learning continues.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, Parametrised, param, part
from martensite.kernels.namespace import Flag, Namespace, Scalar

PATIENCE = 3
"""Successive repetitions with a growing error after which learning may have diverged."""
RISE = 0.02
"""Relative rise of the error that exceeds scatter."""
SLIGHT = 1e-6
"""Fraction of the time between two points that is rounding."""
Line: TypeAlias = tuple[Scalar, ...]


class TaskScore(NamedTuple):
    """Error of the repetitions."""

    squares: Scalar
    """Integral of the squared error of this repetition so far."""
    repetition: Scalar
    """Number of complete repetitions."""
    error: Scalar
    """Rms error of the last complete repetition."""
    streak: Scalar
    """Number of successive repetitions with a growing error."""
    start: Scalar
    """Error before this streak."""
    learning: Scalar
    """1; 0 after divergence."""


class TaskMemory(NamedTuple):
    """Memory of a repeated task."""

    elapsed: Scalar
    """Time since the last point [s]."""
    place: Scalar
    """Index of the last point."""
    ahead: Line
    """v of this point and of future points."""
    past: Line
    """v of past points, newest first."""
    waiting: Line
    """w before smoothing, newest first."""
    score: TaskScore


class TaskMoment(NamedTuple):
    """State of the task in one sample."""

    due: Flag
    """True at a point."""
    begins: Flag
    """True at the first point of a repetition."""
    learned: Scalar
    """v at this time."""
    memory: TaskMemory
    """Memory at this time, before the error is learned."""


class RepeatedTask(Parametrised):
    """Parameters of a repeated task and of its learning."""

    period: Number = param("s", "time from one sample to the next", above=0.0, typical="20 ms")
    task: Number = param("s", "time from one repetition to the next", above=0.0, typical="10 s")
    points: int = part("stored points of a repetition", default=100)
    lead: Number = param("s", "λ, delay of the plant", low=0.0, default=0.0)
    smoothing: int = part("h, half the width of the filter, in points", default=1)
    forgetting: Number = param("1", "φ, fraction that is forgotten in a repetition", low=0.0, high=1.0, default=0.0)
    growth: Number = param("1", "growth of the error above which learning diverges", low=1.0, default=2.0)

    def check(self) -> None:
        for name, least in (("points", 4), ("smoothing", 0)):
            count = self.__dict__[name]
            if not isinstance(count, int) or count < least:
                raise ParameterError(
                    f"`{name}` of a repeated task must be a whole number from {least} on, not {count!r}."
                )
        if not self.spacing >= (1.0 - SLIGHT) * self.period:
            raise ParameterError(
                f"A task of {self.task:g} s has {self.task / self.period:.4g} samples of {self.period:g} s, but "
                f"`points` asks for {self.points}; try {math.floor(self.task / self.period + SLIGHT)}."
            )
        lead = round(self.lead / self.spacing)
        if lead + self.smoothing > self.points - 2:
            raise ParameterError(
                f"A lead of {self.lead:g} s and a smoothing of {self.smoothing} points do not fit into a task of "
                f"{self.points} points, one every {self.spacing:g} s."
            )
        self.__dict__["_layout"] = (self.points, lead, self.smoothing)

    @property
    def spacing(self) -> Scalar:
        """Return the time between two points [s]."""
        return self.task / self.points

    def begin_task(self) -> TaskMemory:
        """Return the memory before the first point."""
        points, lead, half = self.layout()
        ahead, past, waiting = ((0.0,) * count for count in (points - lead - half + 1, lead + half, 2 * half))
        score = TaskScore(0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
        return TaskMemory(self.spacing, -1.0, ahead, past, waiting, score)

    def advance_task(self, xp: Namespace, before: TaskMemory, dt: Scalar) -> TaskMoment:
        """Return the state of the task after a time [s]."""
        elapsed = before.elapsed + dt
        due = elapsed >= (1.0 - SLIGHT) * self.spacing
        place = before.place + 1.0
        begins = xp.both(due, place > self.layout()[0] - 0.5)
        place = xp.where(due, xp.where(begins, 0.0, place), before.place)
        elapsed = xp.where(due, elapsed - self.spacing, elapsed)
        past = (before.ahead[0], *before.past)[: len(before.past)]
        ahead = (*before.ahead[1:], before.ahead[-1])
        moved = before._replace(
            elapsed=elapsed,
            place=place,
            ahead=_choose_line(xp, due, ahead, before.ahead),
            past=_choose_line(xp, due, past, before.past),
        )
        one, other = moved.ahead[:2]
        learned = one + elapsed / self.spacing * (other - one)
        return TaskMoment(due, begins, before.score.learning * learned, moved)

    def learn_error(
        self,
        xp: Namespace,
        now: TaskMoment,
        gain: Scalar,
        error: Scalar,
        counted: Scalar,
        dt: Scalar,
        *,
        seam: bool = True,
    ) -> TaskMemory:
        """Return the memory after a sample with an error.

        Args:
            xp: namespace.
            now: state of the task.
            gain: g.
            error: measured error.
            counted: part of the error that is learned.
            dt: time since the last sample [s].
            seam: whether the end of a repetition is learned for the start of the next.
        """
        score = self._judge(xp, now, error, dt)
        _, lead, half = self.layout()
        memory = now.memory
        valid = memory.place > lead - 0.5
        valid = xp.either(valid, score.repetition > 0.5) if seam else valid
        counted = xp.where(valid, score.learning * counted, 0.0)
        values = (memory.ahead[0], *memory.past)
        waiting = (values[lead] + gain * counted, *memory.waiting)
        smooth = (1.0 - self.forgetting) * sum(c * w for c, w in zip(find_weights(half), waiting, strict=True))
        return memory._replace(
            ahead=(*memory.ahead[:-1], xp.where(now.due, smooth, memory.ahead[-1])),
            waiting=_choose_line(xp, now.due, waiting[: 2 * half], memory.waiting),
            score=score,
        )

    def _judge(self, xp: Namespace, now: TaskMoment, error: Scalar, dt: Scalar) -> TaskScore:
        before = now.memory.score
        squares = before.squares + error**2 * dt
        rms = xp.sqrt(squares / self.task)
        worse = xp.both(rms > (1.0 + RISE) * before.error, before.repetition > 0.5)
        streak = xp.where(worse, before.streak + 1.0, 0.0)
        start = xp.where(worse, before.start, rms)
        diverged = xp.both(streak > PATIENCE - 0.5, rms > self.growth * start)
        learning = xp.where(diverged, 0.0, before.learning)
        after = TaskScore(0.0, before.repetition + 1.0, rms, streak, start, learning)
        return TaskScore(*_choose_line(xp, now.begins, after, before._replace(squares=squares)))


def find_weights(half: int) -> list[float]:
    """Return the weights c of the binomial filter."""
    return [math.comb(2 * half, i) / 4.0**half for i in range(2 * half + 1)]


def _choose_line(xp: Namespace, flag: Flag, one: Sequence[Scalar], other: Sequence[Scalar]) -> Line:
    """Return one of two lines; an elementwise loop compiles faster than long C code."""

    def choose(a: Scalar, b: Scalar) -> tuple[Scalar]:
        return (xp.where(flag, a, b),)

    return tuple(xp.each(choose, one, other)[0]) if other else ()
