r"""Repetitive control: a PID controller with the internal model of whatever repeats.

    u = C (e + v),        v = Q z^{-N} (v + g z^λ e)

C is a PID controller, N the length of the task in points, z^λ the lead
(`martensite.control.controllers.repeated_task`): a generator of all that has the period of the task, references and
disturbances alike, plugged in before a controller that is stable without it. With T = C G/(1 + C G) the loop stays
stable if

    |Q(ω) (1 - g e^{iωλ} T(ω))| < 1         at all ω

so that g is a share: 0.5 is a good start, with the time by which T is late for the lead. Iterative learning adds to
the signal and can be put back between repetitions; this one adds to the error, and PID gains count for what it learns.

Nothing is learned where the signal is at a limit and the error would drive it further. When the error grows from
repetition to repetition, learning stops, v is used no more, and `learning` is 0. Only the PID controller remains.

Source: Hara, Yamamoto, Omata and Nakano (1988), modified repetitive control.
"""

from martensite.base.parameters import Number, param
from martensite.control.controllers.base import CONTROLLERS, Answer, Column, Readings
from martensite.control.controllers.iterative_learning import AbstractLearning, LearningMemory
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import flatten_numbers


@CONTROLLERS.register("repetitive")
class Repetitive(AbstractLearning):
    """A PID controller with the internal model of a period plugged in."""

    cites = ("hara1988",)
    adds_error = True

    learning_gain: Number = param("1", "g, share of an error that is learned in a repetition", low=0.0, default=0.5)

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        """Return the signal of this sample, and the memory for the next sample."""
        before, found = self.rebuild_memory(memory), readings[self.measured]
        now, error = self.advance_task(xp, before.task, dt), reference - found
        signal, pid = self.respond(xp, before.pid, reference, found - now.learned, dt)
        learned = self.limit_learning(xp, signal, error, self.gains.Kp + self.gains.Ki)
        task = self.learn_error(xp, now, self.learning_gain, error, learned, dt)
        return signal, flatten_numbers(LearningMemory(task, pid, now.learned))

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        """With the integral that gives the signal."""
        held, found = self.rebuild_memory(memory), readings[self.measured]
        pid = self.law.track(xp, self.gains, held.pid, signal, reference, found - held.learned)
        return flatten_numbers(held._replace(pid=pid))
