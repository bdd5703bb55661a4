"""A PID controller around an identified model, as one block that runs in C.

In every sample the output of the model is measured under the signal of the last sample; the controller answers, and the
model advances under the answer. A model with a delay of one sample therefore adds no delay to the loop.

    in: reference        out: measured output, then the signal

The free numbers are the logarithms of the gains: other gains, and exact derivatives with respect to them, need no
compilation. The parameters of the model are fixed numbers of the block, so that loops around models of one structure
share a program.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from typing import Any, NamedTuple, Self

import numpy as np

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param, part
from martensite.control.controllers.pid import Gains, PidLaw, PidMemory
from martensite.control.tuning.rest_check import check_static_curve
from martensite.identify.blocks.base import AbstractBlock, Column, Numbers
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.engine import ChainEngine
from martensite.kernels.namespace import Namespace, Scalar

KEPT = 4
"""Number of states of the loop: three of the controller, and its last signal."""
SMALLEST_GAIN = 1e-30
"""Lower bound of a gain for its logarithm."""


class ClosedLoop(AbstractBlock):
    """A controller and the blocks of a model, made by `ControlledModel`."""

    short = "loop"

    blocks: tuple[AbstractBlock, ...] = part("blocks of the model")
    values: tuple[Any, ...] = part("free and fixed numbers of all blocks, in their order")
    tap: tuple[int, int] = part("block and output that are measured")
    offset: Any = part("offset that is subtracted from that output", default=0.0)
    law: PidLaw = part("limits, set-point weights and filter", default=PidLaw())
    sign: Number = param("1", "-1 if the output falls when the signal rises, else 1", default=1.0)

    @property
    def outputs(self) -> int:
        return 2

    def numbers(self) -> tuple[str, ...]:
        return "log_Kp", "log_Ki", "log_Kd"

    def states(self) -> int:
        return KEPT + sum(block.states() for block in self.blocks)

    @property
    def fixed(self) -> tuple[str, ...]:  # type: ignore[override]
        return (*(f"m{k}" for k in range(len(self.values))), "offset")

    def fixed_values(self) -> tuple[float, ...]:
        return (*self.values, self.offset)

    def with_fixed_values(self, values: Sequence[Any]) -> Self:
        return self.rebuilt({"values": tuple(values[:-1]), "offset": values[-1]})

    def structure(self) -> tuple[Any, ...]:
        inner = tuple(block.structure() for block in self.blocks)
        return type(self), inner, self.tap, repr(self.law), self.sign

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        signals: Column = (self.law.idle,)
        states: list[Scalar] = []
        measured: Scalar = 0.0
        for k, (block, values) in enumerate(self._parts()):
            state = block.rest(xp, values, signals, dt)
            signals, _ = block.step(xp, values, state, signals, dt)
            measured = signals[self.tap[1]] if k == self.tap[0] else measured
            states += state
        memory = self.law.rest(xp, x[0], measured - self.offset)
        return [*memory, self.law.idle, *states]

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        memory, before, inner = PidMemory(*state[:3]), state[3], state[KEPT:]
        measured, _ = self._model(xp, inner, before, dt)
        gains = Gains(*(self.sign * xp.exp(number) for number in theta))
        signal, memory = self.law.answer(xp, gains, memory, x[0], measured, dt, sampled=True)
        _, inner = self._model(xp, inner, signal, dt)
        return (measured, signal), [*memory, signal, *inner]

    def _model(self, xp: Namespace, state: Column, signal: Scalar, dt: Scalar) -> tuple[Scalar, list[Scalar]]:
        signals: Column = (signal,)
        after: list[Scalar] = []
        measured: Scalar = 0.0
        first = 0
        for k, (block, values) in enumerate(self._parts()):
            last = first + block.states()
            signals, state_after = block.step(xp, values, state[first:last], signals, dt)
            measured = signals[self.tap[1]] if k == self.tap[0] else measured
            after += state_after
            first = last
        return measured - self.offset, after

    def _parts(self) -> list[tuple[AbstractBlock, Column]]:
        rest = iter(self.values)
        rows = [
            (one, *(tuple(islice(rest, len(names))) for names in (one.numbers(), one.fixed))) for one in self.blocks
        ]
        return [(block.with_fixed_values(fixed), free) for block, free, fixed in rows]


class Trajectory(NamedTuple):
    """A run of a controlled model or bench."""

    reference: Numbers
    output: Numbers
    signal: Numbers
    interval: float
    """Sample time [s]."""


class ControlledModel:
    """A model under PID control, ready to run with any gains."""

    def __init__(
        self,
        chain: Chain,
        law: PidLaw | None = None,
        measured: int = -1,
        zeroed: bool = True,
        reverse: bool = False,
        compiled: bool | None = None,
    ) -> None:
        """Close the loop around a model.

        Args:
            chain: model with one input.
            law: limits, set-point weights and filter of the controller.
            measured: number of the controlled output.
            zeroed: whether the steady output under the idle signal is subtracted.
            reverse: whether the output falls when the signal rises.
            compiled: whether to run in C; default: if there is a compiler.

        Raises:
            ParameterError: the model has several inputs, or has no such output.
        """
        if chain.inputs != 1:
            raise ParameterError(f"A controlled model has one input, not {chain.inputs}.")
        taps = chain.engine.taps
        if not -len(taps) <= measured < len(taps):
            raise ParameterError(f"The model has {len(taps)} outputs; there is no {measured}.")
        self.chain, law = chain, law or PidLaw()
        self._measured, self._zeroed = measured, zeroed
        parts = zip(chain.blocks, chain.split(), strict=True)
        values = [float(v) for block, values_of_block in parts for v in (*values_of_block, *block.fixed_values())]
        block = ClosedLoop(
            blocks=chain.blocks, values=tuple(values), tap=taps[measured], law=law, sign=-1.0 if reverse else 1.0
        )
        if zeroed:
            idle = np.full((1, 1), law.idle)
            block = block.with_fixed_values([*values, float(chain.simulate(idle)[0, measured])])
        self.block, self.engine = block, ChainEngine([block], chain.interval, compiled=compiled)

    def check_static_curve(self, targets: Sequence[float]) -> None:
        """Raise `ParameterError` if the model or a target is outside the range of its records."""
        wanted = targets if self._zeroed else ()
        check_static_curve(self.chain, self.block.law.idle, wanted, self._measured)

    def run(self, gains: Gains, reference: Numbers) -> Trajectory:
        """Return a run from the steady state for gains of one sign or 0."""
        columns = self.engine.simulate(compute_logarithms(gains), _build_column(reference))
        return Trajectory(reference, columns[:, 0], columns[:, 1], self.chain.interval)

    def slopes(self, gains: Gains, reference: Numbers) -> tuple[Numbers, Numbers]:
        """Return output and signal, shape (samples, 2), and their derivatives with respect to log gains.

        The derivatives hold between switchings of the controller: where another gain changes the sample at which the
        integral stops, the run itself jumps a little.
        """
        return self.engine.jacobian(compute_logarithms(gains), _build_column(reference))


def compute_logarithms(gains: Gains) -> Numbers:
    """Return the logarithms of the sizes of gains."""
    return np.log(np.maximum(np.abs(np.array(gains, dtype=float)), SMALLEST_GAIN))


def _build_column(reference: Numbers) -> Numbers:
    return np.asarray(reference, dtype=float)[:, None]
