"""Signals of a controller at constant readings and a constant reference."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from martensite.control.controllers.base import AbstractController
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.program import Program


def iterate_signals(
    controller: AbstractController, readings: Mapping[str, float], reference: float, period: float, samples: int
) -> Iterator[float]:
    """Yield the signals of a controller at constant readings, from its initial memory.

    Samples after the first are traced: on floats a controller with a model, such as a feed-forward, is 100 times
    slower.

    Args:
        controller: controller, without its slew limit and manual mode.
        readings: readings and previews of the reference by name, in SI.
        reference: reference in SI.
        period: sample period [s].
        samples: number of signals.
    """
    memory: Sequence[float] = controller.rest(floats, reference, readings)
    signal, memory = controller.answer(floats, tuple(memory), reference, readings, period)
    yield float(signal)
    if samples == 1:
        return

    def answer(xp: Namespace, *numbers: Scalar) -> Sequence[Scalar]:
        signal, after = controller.answer(xp, numbers, reference, readings, period)
        return [signal, *after]

    program = Program()
    program.add("answer", [f"m{i}" for i in range(len(memory))], answer)
    proceed = program.bind_floats()["answer"]
    for _ in range(samples - 1):
        signal, *memory = proceed(*memory)
        yield signal
