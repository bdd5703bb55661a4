r"""Iterative learning control: a signal that is learned along a task that repeats.

    u = v_j + C e,        v_j+1 = Q (v_j + g z^λ e_j)

where C is a PID controller, v_j the signal learned in the repetitions before (`martensite.control.controllers.
repeated_task`), z^λ the lead. For a linear plant G, in repetitions that follow each other, the error goes from one to
the next by

    |Q(ω) (1 - g e^{iωλ} G/(1 + C G))| < 1         at all ω

and it converges where that holds; what remains is due to Q, which is 1 at rest only. A good start is half of K_p for
the learning gain g, and for the lead the time by which the closed loop is late.

Nothing is learned where the signal is at a limit and the error would drive it further. When the error grows from
repetition to repetition, learning stops, v is used no more, and `learning` is 0. Only the PID controller remains.

Sources: Arimoto, Kawamura and Miyazaki (1984); Bristow, Tharayil and Alleyne (2006), parallel architecture.
"""

from collections.abc import Mapping
from typing import ClassVar, NamedTuple

from martensite.actuators.mechanisms.base import Output
from martensite.base.parameters import Number, option, param
from martensite.base.units import GAIN
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings
from martensite.control.controllers.pid import PidGains, PidMemory
from martensite.control.controllers.repeated_task import RepeatedTask, TaskMemory
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, choose_tuple, flatten_numbers


class LearningMemory(NamedTuple):
    """Memory of a controller that learns."""

    task: TaskMemory
    pid: PidMemory
    learned: Scalar
    """v of the last sample."""


class AbstractLearning(PidGains, RepeatedTask, AbstractController):
    """A PID controller with something that it learns along a task."""

    adds_error: ClassVar[bool] = False
    """True if the controller learns an error, False if it learns a signal."""
    integrals = (-4,)

    def check(self) -> None:
        """Raise `ParameterError` for gains said twice, or a task that cannot be."""
        PidGains.check(self)
        RepeatedTask.check(self)

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        """Nothing learned, nothing integrated."""
        pid = self.law.rest(xp, reference, readings[self.measured])
        return flatten_numbers(LearningMemory(self.begin_task(), pid, 0.0))

    def list_outputs(self, unit: str, signal: str) -> dict[str, Output]:
        """Return the outputs for the state of learning and the learned value."""
        return {
            "repetition": Output("1", "whole repetitions of the task", "j"),
            "error": Output(unit, "rms error of the last repetition", "e_rms"),
            "learning": Output("1", "whether it learns (1) or has stopped, for it diverged (0)", "l"),
            "learned": Output(unit if self.adds_error else signal, "what was learned", "v"),
        }

    def observe(self, xp: Namespace, memory: Column) -> Column:
        """Return the state of learning and the learned value."""
        held = self.rebuild_memory(memory)
        score = held.task.score
        return [score.repetition, score.error, score.learning, held.learned]

    def describe_doubts(self, last: Mapping[str, float]) -> list[str]:
        """Return a warning if learning has stopped."""
        if last["learning"] > 0.5:
            return []
        return [
            "Warning: Learning has stopped, for the error grew from repetition to repetition. Try half the learning "
            "gain, a lead as long as the loop is late, or more smoothing."
        ]

    def rebuild_memory(self, memory: Column) -> LearningMemory:
        """Return the memory by name."""
        example = LearningMemory(self.begin_task(), PidMemory(*[0.0] * len(PidMemory._fields)), 0.0)
        return NestedShape(example).rebuild(memory)

    def limit_learning(self, xp: Namespace, signal: Scalar, error: Scalar, way: Scalar) -> Scalar:
        """Return the learned part of an error: 0 where the signal is at a limit and the error drives it further."""
        push = way * error
        over = xp.both(signal >= self.law.high, push > 0.0)
        under = xp.both(signal <= self.law.low, push < 0.0)
        return xp.where(xp.either(over, under), 0.0, error)


@CONTROLLERS.register("iterative-learning")
class IterativeLearning(AbstractLearning):
    """A PID controller with a feed-forward that is learned from repetition to repetition."""

    cites = ("arimoto1984", "bristow2006")

    learning_gain: Number = param(GAIN, "g, learned from an error in a repetition", typical=50.0)
    between: str = option(
        "from one repetition to the next: the plant goes on, or it was put back to where it began",
        "continuous",
        "reset",
        default="continuous",
    )

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        """Return the signal of this sample, and the memory for the next sample."""
        before, found = self.rebuild_memory(memory), readings[self.measured]
        now, pid = self.advance_task(xp, before.task, dt), before.pid
        if self.between == "reset":
            first = self.law.rest(xp, reference, found)
            pid = choose_tuple(xp, now.begins, first, pid)
        feed = now.learned
        left = {"low": self.law.low - feed, "high": self.law.high - feed}
        added, pid = self.law.rebuilt(left).answer(xp, self.gains, pid, reference, found, dt, self.sampled)
        signal, error = xp.clip(feed + added, self.law.low, self.law.high), reference - found
        learned = self.limit_learning(xp, signal, error, self.learning_gain)
        seam = self.between == "continuous"
        task = self.learn_error(xp, now, self.learning_gain, error, learned, dt, seam=seam)
        return signal, flatten_numbers(LearningMemory(task, pid, feed))

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        """With the integral that gives the signal beside what is learned."""
        held, found = self.rebuild_memory(memory), readings[self.measured]
        pid = self.law.track(xp, self.gains, held.pid, signal - held.learned, reference, found)
        return flatten_numbers(held._replace(pid=pid))
