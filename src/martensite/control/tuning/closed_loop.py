"""A PID controller around an identified model, as one block that runs in C.

In every sample the output of the model is measured, under the signal of the sample before; the
controller answers, and the model goes on under that answer. A model whose output follows its
input only a sample later (delay 1) thus sees no delay of the loop.

    in: reference        out: what is measured, then the signal

The free numbers are the logarithms of the gains, so a loop is run for other gains, and its exact
derivatives with respect to them are had, without another compilation; the numbers of the model
are fixed numbers of the block, so that loops around models of one structure share a program.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Self, cast

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
"""States of the loop itself: three of the controller, and its last signal."""
SMALLEST_GAIN = 1e-30
"""Gains below are this, so that they have a logarithm."""


class ClosedLoop(AbstractBlock):
    """A controller and the blocks of a model. Use `closed_loop` to make one."""

    short = "loop"

    blocks: tuple[AbstractBlock, ...] = part("blocks of the model")
    values: tuple[Any, ...] = part("free and fixed numbers of all blocks, in their order")
    tap: tuple[int, int] = part("which block and which of its outputs is measured")
    offset: Any = part("what is taken off that output", default=0.0)
    law: PidLaw = part("limits, set-point weights and filter", default=PidLaw())
    sign: Number = param("1", "-1 if the output falls when the signal rises, else 1", default=1.0)

    @property
    def outputs(self) -> int:
        """Return the number of outputs: the measured output and the signal."""
        return 2

    def numbers(self) -> tuple[str, ...]:
        """Return the gains."""
        return "log_Kp", "log_Ki", "log_Kd"

    def states(self) -> int:
        """Return the number of states: of the controller, its last signal, and of the model."""
        return KEPT + sum(block.states() for block in self.blocks)

    @property
    def fixed(self) -> tuple[str, ...]:  # type: ignore[override]
        """Return the names of the numbers of the model, and the offset."""
        return (*(f"m{k}" for k in range(len(self.values))), "offset")

    def given(self) -> tuple[float, ...]:
        """Return the numbers of the model, and the offset."""
        return (*self.values, self.offset)

    def with_given(self, values: Sequence[Any]) -> Self:
        """Return a twin around a model with other numbers."""
        return self.rebuilt({"values": tuple(values[:-1]), "offset": values[-1]})

    def structure(self) -> tuple[Any, ...]:
        """Return the structure of the blocks, and all numbers of the law."""
        inner = tuple(block.structure() for block in self.blocks)
        return type(self), inner, self.tap, repr(self.law), self.sign

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        """Return the model at rest under the idle signal, before it is controlled."""
        signals: Column = (self.law.idle,)
        kept: list[Scalar] = []
        measured: Scalar = 0.0
        for k, (block, own) in enumerate(self._parts()):
            state = block.rest(xp, own, signals, dt)
            signals, _ = block.step(xp, own, state, signals, dt)
            measured = signals[self.tap[1]] if k == self.tap[0] else measured
            kept += state
        memory = self.law.rest(xp, x[0], measured - self.offset)
        return [*memory, self.law.idle, *kept]

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Measure, answer, go on."""
        memory, before, inner = PidMemory(*state[:3]), state[3], state[KEPT:]
        measured, _ = self._model(xp, inner, before, dt)
        gains = Gains(*(self.sign * xp.exp(number) for number in theta))
        signal, memory = self.law.answer(xp, gains, memory, x[0], measured, dt, sampled=True)
        _, inner = self._model(xp, inner, signal, dt)
        return (measured, signal), [*memory, signal, *inner]

    def _model(self, xp: Namespace, state: Column, signal: Scalar, dt: Scalar) -> tuple[Scalar, list[Scalar]]:
        """Return the measured output of the model under a signal, and its next state."""
        signals: Column = (signal,)
        after: list[Scalar] = []
        measured: Scalar = 0.0
        first = 0
        for k, (block, own) in enumerate(self._parts()):
            last = first + block.states()
            signals, held = block.step(xp, own, state[first:last], signals, dt)
            measured = signals[self.tap[1]] if k == self.tap[0] else measured
            after += held
            first = last
        return measured - self.offset, after

    def _parts(self) -> list[tuple[AbstractBlock, Column]]:
        """Return the blocks with their fixed numbers set, and their free numbers."""
        found: list[tuple[AbstractBlock, Column]] = []
        place = 0
        for block in self.blocks:
            free, fixed = len(block.numbers()), len(block.fixed)
            own = self.values[place : place + free]
            given = self.values[place + free : place + free + fixed]
            found.append((block.with_given(given), own))
            place += free + fixed
        return found


class Trajectory(NamedTuple):
    """A run of a controlled model or bench."""

    reference: Numbers
    output: Numbers
    """Measured output."""
    signal: Numbers
    """Signal of the controller."""
    interval: float
    """[s]"""


class ControlledModel:
    """A model under PID control, ready to run for any gains."""

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
            chain: the model; one input.
            law: limits, set-point weights and filter of the controller.
            measured: which of its outputs is controlled.
            zeroed: whether the output at rest under the idle signal counts as zero.
            reverse: whether the output falls when the signal rises.
            compiled: whether to run in C; by default if there is a compiler.

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
        values = [float(v) for block, own in parts for v in (*own, *block.given())]
        block = ClosedLoop(
            blocks=chain.blocks, values=tuple(values), tap=taps[measured], law=law, sign=-1.0 if reverse else 1.0
        )
        if zeroed:
            idle = np.full((1, 1), law.idle)
            block = block.with_given([*values, float(chain.simulate(idle)[0, measured])])
        self.block, self.engine = block, ChainEngine([block], chain.interval, compiled=compiled)

    def check_static_curve(self, targets: Sequence[float]) -> None:
        """Raise `ParameterError` if the model is at rest where its records never were, or is to be driven there."""
        wanted = targets if self._zeroed else ()
        check_static_curve(self.chain, self.block.law.idle, wanted, self._measured)

    def run(self, gains: Gains, reference: Numbers) -> Trajectory:
        """Return a run from rest, for gains of one sign or 0."""
        found = self.engine.simulate(compute_logarithms(gains), _build_column(reference))
        return Trajectory(reference, found[:, 0], found[:, 1], self.chain.interval)

    def slopes(self, gains: Gains, reference: Numbers) -> tuple[Numbers, Numbers]:
        """Return the output and signal, shape (samples, 2), and derivatives with respect to log gains.

        They are those between the switchings of the controller: where another gain makes the
        integral stop or go on a sample earlier, the run itself jumps a little.
        """
        return self.engine.jacobian(compute_logarithms(gains), _build_column(reference))


def compute_logarithms(gains: Gains) -> Numbers:
    """Return the logarithms of the sizes of gains."""
    return np.log(np.maximum(np.abs(np.array(gains, dtype=float)), SMALLEST_GAIN))


def _build_column(reference: Numbers) -> Numbers:
    return cast("Numbers", np.asarray(reference, dtype=float))[:, None]
