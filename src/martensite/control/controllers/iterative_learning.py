"""Iterative learning control: a signal that is learned along a task that repeats.

    u = v_j + C e,        v_j+1 = Q (v_j + g z^λ e_j)

C is a PID controller, v_j the signal learned in the previous repetitions (`martensite.control.controllers.
repeated_task`), z^λ the lead. For a linear plant G and repetitions without a pause the error converges if

    |Q(ω) (1 - g e^{iωλ} G/(1 + C G))| < 1         at all ω

The remaining error is due to Q, which is 1 only at ω = 0. Start with half of K_p for the learning gain g, and with the
delay of the closed loop for the lead.

An error is not learned where the signal is at a limit and the error drives it further. If the error grows from
repetition to repetition, learning stops, v is no longer used, `learning` is 0, and the PID controller remains.

Sources: Arimoto, Kawamura and Miyazaki (1984); Bristow, Tharayil and Alleyne (2006), parallel architecture.
"""

from collections.abc import Mapping
from typing import ClassVar, NamedTuple

from martensite.actuators.mechanisms.base import Output
from martensite.base.parameters import Number, option, param
from martensite.base.units import GAIN
from martensite.control.controllers.base import CONTROLLERS, AbstractController, Answer, Column, Readings
from martensite.control.controllers.pid import NO_MEMORY, PidGains, PidMemory
from martensite.control.controllers.repeated_task import RepeatedTask, TaskMemory
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import NestedShape, choose_tuple, flatten_numbers


class LearningMemory(NamedTuple):
    """Memory of a controller that learns."""

    task: TaskMemory
    pid: PidMemory
    learned: Scalar


class AbstractLearning(PidGains, RepeatedTask, AbstractController):
    """A PID controller that learns along a repeated task."""

    adds_error: ClassVar[bool] = False
    """True if the controller learns an error, False if it learns a signal."""
    integrals = (-4,)

    def check(self) -> None:
        PidGains.check(self)
        RepeatedTask.check(self)

    def rest(self, xp: Namespace, reference: Scalar, readings: Readings) -> Column:
        pid = self.law.rest(xp, reference, readings[self.measured])
        return flatten_numbers(LearningMemory(self.begin_task(), pid, 0.0))

    def list_outputs(self, unit: str, signal: str) -> dict[str, Output]:
        return {
            "repetition": Output("1", "whole repetitions of the task", "j"),
            "error": Output(unit, "rms error of the last repetition", "e_rms"),
            "learning": Output("1", "whether it learns (1) or has stopped, for it diverged (0)", "l"),
            "learned": Output(unit if self.adds_error else signal, "what was learned", "v"),
        }

    def observe(self, xp: Namespace, memory: Column) -> Column:
        memory_parts = self.rebuild_memory(memory)
        score = memory_parts.task.score
        return [score.repetition, score.error, score.learning, memory_parts.learned]

    def describe_doubts(self, last: Mapping[str, float]) -> list[str]:
        if last["learning"] > 0.5:
            return []
        return [
            "Warning: Learning has stopped, for the error grew from repetition to repetition. Try half the learning "
            "gain, a lead as long as the loop is late, or more smoothing."
        ]

    def rebuild_memory(self, memory: Column) -> LearningMemory:
        """Return the named memory from a flat column."""
        return NestedShape(LearningMemory(self.begin_task(), NO_MEMORY, 0.0)).rebuild(memory)

    def limit_learning(self, xp: Namespace, signal: Scalar, error: Scalar, way: Scalar) -> Scalar:
        """Return the error to be learned: 0 where the signal is at a limit and the error drives it further."""
        return self.law.hold_at_limit(xp, signal, way * error, 0.0, error)


@CONTROLLERS.register("iterative-learning")
class IterativeLearning(AbstractLearning):
    """A PID controller with a feed-forward that is learned from repetition to repetition."""

    cites = ("arimoto1984", "bristow2006")

    learning_gain: Number = param(GAIN, "g, learned from an error in a repetition", typical=50.0)
    between: str = option(
        "between repetitions the plant continues, or is reset to its start", "continuous", "reset", default="continuous"
    )

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        before, value = self.rebuild_memory(memory), readings[self.measured]
        now, pid = self.advance_task(xp, before.task, dt), before.pid
        if self.between == "reset":
            first = self.law.rest(xp, reference, value)
            pid = choose_tuple(xp, now.begins, first, pid)
        feed = now.learned
        limits = {"low": self.law.low - feed, "high": self.law.high - feed}
        added, pid = self.law.rebuilt(limits).answer(xp, self.gains, pid, reference, value, dt, self.sampled)
        signal, error = xp.clip(feed + added, self.law.low, self.law.high), reference - value
        learned = self.limit_learning(xp, signal, error, self.learning_gain)
        seam = self.between == "continuous"
        task = self.learn_error(xp, now, self.learning_gain, error, learned, dt, seam=seam)
        return signal, flatten_numbers(LearningMemory(task, pid, feed))

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        before, value = self.rebuild_memory(memory), readings[self.measured]
        pid = self.law.track(xp, self.gains, before.pid, signal - before.learned, reference, value)
        return flatten_numbers(before._replace(pid=pid))
