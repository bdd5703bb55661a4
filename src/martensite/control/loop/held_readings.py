"""Signals of a controller whose readings and reference do not change, sample by sample."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from martensite.control.controllers.base import AbstractController
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar
from martensite.kernels.program import Program


def iterate_signals(
    controller: AbstractController, readings: Mapping[str, float], reference: float, period: float, samples: int
) -> Iterator[float]:
    """Yield the signals of a controller that starts at rest and reads the same in every sample.

    The second and all later samples are traced: a controller that carries a model, such as a feed-forward, takes
    100 times as long on floats.

    Args:
        controller: answers without the slew limit and the manual signals around it.
        readings: readings and previews of the reference by name, in SI.
        reference: reference in SI.
        period: time between two samples [s].
        samples: number of signals.
    """
    memory: Sequence[float] = controller.rest(floats, reference, readings)
    signal, memory = controller.answer(floats, tuple(memory), reference, readings, period)
    yield float(signal)
    if samples == 1:
        return

    def answer(xp: Namespace, *held: Scalar) -> Sequence[Scalar]:
        signal, after = controller.answer(xp, held, reference, readings, period)
        return [signal, *after]

    program = Program()
    program.add("answer", [f"m{i}" for i in range(len(memory))], answer)
    proceed = program.bind_floats()["answer"]
    for _ in range(samples - 1):
        signal, *memory = proceed(*memory)
        yield signal
