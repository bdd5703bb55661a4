r"""Memory of a controller that learns along a repeated task: one repetition.

    w_j(k) = v_j(k) + g e_j(k + λ)
    v_j+1(k) = (1 - φ) Σ_i c_i w_j(k + i),       c_i = C(2 h, h + i)/4^h,   i = -h … h

v_j(k) is what was learned by the repetition j, at the point k = 0 … N - 1 of the task, and e the error. The lead λ
makes up for how late the plant answers. The weights c are those of a binomial: a filter Q of no phase, which keeps what
repeats slowly and forgets what the plant cannot follow; it passes cos^2h(ω/2) at ω per point. The share φ is forgotten
in every repetition. Between points v is linear in time; errors count where they are at a point.

The memory is a line that moves on by one place at every point: values to come, those of the last points, and those
that wait for their neighbours to be smoothed. One repetition follows the other without a gap.

It stops learning when it diverges: when the rms error of a repetition has risen by more than 2 % `PATIENCE` times in a
row, and by more than the factor `growth` in all. Then the learned signal is used no more. A plant that changes does
not do that: its error jumps once and is learned away.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, Parametrised, param, part
from martensite.kernels.namespace import Flag, Namespace, Scalar

PATIENCE = 3
"""Repetitions in a row, each worse than the one before, after which it may have diverged."""
RISE = 0.02
"""Share by which an error must rise to be worse than the one before, and no scatter."""
SLIGHT = 1e-6
"""Part of the time between two points that is rounding."""
Line: TypeAlias = tuple[Scalar, ...]


class TaskScore(NamedTuple):
    """Score of how well a task is repeated."""

    squares: Scalar
    """Squared error of this repetition so far, integrated over time."""
    repetition: Scalar
    """Whole ones so far."""
    error: Scalar
    """Rms of the last whole one."""
    streak: Scalar
    """Repetitions in a row that were worse than the one before."""
    start: Scalar
    """Error before they began."""
    learning: Scalar
    """1, or 0 since it has diverged."""


class TaskMemory(NamedTuple):
    """Memory of a task."""

    elapsed: Scalar
    """Time since the last point [s]."""
    place: Scalar
    """The last point, from 0."""
    ahead: Line
    """v of this point and of those to come."""
    past: Line
    """v of the points before, latest first."""
    waiting: Line
    """w, not smoothed yet, latest first."""
    score: TaskScore


class TaskMoment(NamedTuple):
    """Place of a controller in its task at one sample."""

    due: Flag
    """True if a point is due."""
    begins: Flag
    """True if it is the first point of a repetition."""
    learned: Scalar
    """v at this time."""
    memory: TaskMemory
    """With everything moved on, nothing learned yet."""


class RepeatedTask(Parametrised):
    """Parameters of a repeated task and of its learning."""

    period: Number = param("s", "time from one sample to the next", above=0.0, typical="20 ms")
    task: Number = param("s", "time from one repetition to the next", above=0.0, typical="10 s")
    points: int = part("points of a repetition that are remembered", default=100)
    lead: Number = param("s", "λ, how much later than the signal the plant answers", low=0.0, default=0.0)
    smoothing: int = part("h, half the width of the filter, in points", default=1)
    forgetting: Number = param("1", "φ, share that is forgotten in a repetition", low=0.0, high=1.0, default=0.0)
    growth: Number = param("1", "factor by which an error rises that diverges", low=1.0, default=2.0)

    def check(self) -> None:
        """Raise `ParameterError` where a task has no such points; fix what decides the program's size."""
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

    def layout(self) -> tuple[int, ...]:
        """Return the points of a repetition, of the lead and of half the filter."""
        return self.__dict__["_layout"]

    @property
    def spacing(self) -> Scalar:
        """Return the time between two points [s]."""
        return self.task / self.points

    def begin_task(self) -> TaskMemory:
        """Before the first point: nothing learned."""
        points, lead, half = self.layout()
        ahead, past, waiting = ((0.0,) * count for count in (points - lead - half + 1, lead + half, 2 * half))
        score = TaskScore(0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
        return TaskMemory(self.spacing, -1.0, ahead, past, waiting, score)

    def advance_task(self, xp: Namespace, before: TaskMemory, dt: Scalar) -> TaskMoment:
        """Return the moment a time later [s]."""
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
        """Return the memory after a sample with this error.

        Args:
            xp: namespace.
            now: the moment.
            gain: g.
            error: as it is.
            counted: what of it shall be learned.
            dt: time since the sample before [s].
            seam: whether the first errors of a repetition come from the end of the one before.
        """
        score = self._judge(xp, now, error, dt)
        _, lead, half = self.layout()
        memory = now.memory
        own = memory.place > lead - 0.5
        own = xp.either(own, score.repetition > 0.5) if seam else own
        counted = xp.where(own, score.learning * counted, 0.0)
        known = (memory.ahead[0], *memory.past)
        waiting = (known[lead] + gain * counted, *memory.waiting)
        smooth = (1.0 - self.forgetting) * sum(c * w for c, w in zip(find_weights(half), waiting, strict=True))
        return memory._replace(
            ahead=(*memory.ahead[:-1], xp.where(now.due, smooth, memory.ahead[-1])),
            waiting=_choose_line(xp, now.due, waiting[: 2 * half], memory.waiting),
            score=score,
        )

    def _judge(self, xp: Namespace, now: TaskMoment, error: Scalar, dt: Scalar) -> TaskScore:
        """Return the score with one more sample, and at the end of a repetition with that."""
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
    """c, the weights of a binomial filter."""
    return [math.comb(2 * half, i) / 4.0**half for i in range(2 * half + 1)]


def _choose_line(xp: Namespace, flag: Flag, one: Sequence[Scalar], other: Sequence[Scalar]) -> Line:
    """Select one of two lines, place by place; a long line in a loop, which a C compiler reads sooner."""

    def choose(a: Scalar, b: Scalar) -> tuple[Scalar]:
        return (xp.where(flag, a, b),)

    return tuple(xp.each(choose, one, other)[0]) if other else ()
