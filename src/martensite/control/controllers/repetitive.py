"""Repetitive control: a PID controller with the internal model of a periodic task.

    u = C (e + v),        v = Q z^{-N} (v + g z^λ e)

C is a PID controller, N the length of the task in points, z^λ the lead (`martensite.control.controllers.
repeated_task`). The loop compensates references and disturbances with the period of the task. If it is stable without
v, and with T = C G/(1 + C G), it stays stable if

    |Q(ω) (1 - g e^{iωλ} T(ω))| < 1         at all ω

Start with g = 0.5, and with the delay of T for the lead. Iterative learning adds to the signal and allows a reset
between repetitions; repetitive control adds to the error, and the PID gains also act on the learned error.

An error is not learned where the signal is at a limit and the error drives it further. If the error grows from
repetition to repetition, learning stops, v is no longer used, `learning` is 0, and the PID controller remains.

Source: Hara, Yamamoto, Omata and Nakano (1988), modified repetitive control.
"""

from martensite.base.parameters import Number, param
from martensite.control.controllers.base import CONTROLLERS, Answer, Column, Readings
from martensite.control.controllers.iterative_learning import AbstractLearning, LearningMemory
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.nested import flatten_numbers


@CONTROLLERS.register("repetitive")
class Repetitive(AbstractLearning):
    """A PID controller with the internal model of a periodic task."""

    cites = ("hara1988",)
    adds_error = True

    learning_gain: Number = param("1", "g, fraction of the error that is learned in a repetition", low=0.0, default=0.5)

    def answer(self, xp: Namespace, memory: Column, reference: Scalar, readings: Readings, dt: Scalar) -> Answer:
        before, value = self.rebuild_memory(memory), readings[self.measured]
        now, error = self.advance_task(xp, before.task, dt), reference - value
        signal, pid = self.respond(xp, before.pid, reference, value - now.learned, dt)
        learned = self.limit_learning(xp, signal, error, self.gains.Kp + self.gains.Ki)
        task = self.learn_error(xp, now, self.learning_gain, error, learned, dt)
        return signal, flatten_numbers(LearningMemory(task, pid, now.learned))

    def track(self, xp: Namespace, memory: Column, signal: Scalar, reference: Scalar, readings: Readings) -> Column:
        before, value = self.rebuild_memory(memory), readings[self.measured]
        pid = self.law.track(xp, self.gains, before.pid, signal, reference, value - before.learned)
        return flatten_numbers(before._replace(pid=pid))
