"""Joined blocks: in series as one block, summed, or with feedback.

    [a | b]   y = b(a(u))
    [a + b]   y = a(u) + b(u)
    [a < b]   y = a(u - g b(y))

With these and parallel blocks a chain is any graph of blocks: `[oe(2,2,1) < [poly3 + boucwen]]` is a mass on a
hardening, yielding spring. g is a free number that starts at 0. If the forward path delays (`nk` ≥ 1), the output of
this sample is fed back without an equation to solve, else the output of the last sample. In a fitted model it is
limited to 1.5 times its range in the records (`fence_in`), so that a loop with a stable forward path is bounded for
bounded inputs. See decision 039.
"""

from __future__ import annotations

from typing import Any, Self

import numpy as np

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, param, part
from martensite.identify.blocks.base import BLOCKS, AbstractBlock, Column, Numbers
from martensite.identify.blocks.bouc_wen import BoucWen
from martensite.identify.blocks.feedback import BEYOND, LEAST, WIDE
from martensite.identify.blocks.nonlinear_state_space import fixed_point
from martensite.identify.blocks.side_by_side import AbstractComposite
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.kernels import floats
from martensite.kernels.namespace import Namespace, Scalar


@BLOCKS.register("series")
class Series(AbstractComposite):
    """Blocks in series as one block."""

    sign = "|"

    def check(self) -> None:
        super().check()
        for before, after in zip(self.blocks, self.blocks[1:], strict=False):
            if before.outputs != after.inputs:
                raise ParameterError(
                    f"Block `{before.text()}` gives {before.outputs} signals, but `{after.text()}` takes "
                    f"{after.inputs}."
                )

    @property
    def inputs(self) -> int:
        return self.blocks[0].inputs

    @property
    def outputs(self) -> int:
        return self.blocks[-1].outputs

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        states: list[Scalar] = []
        for block, numbers in self.split_numbers(theta):
            state = list(block.rest(xp, numbers, x, dt))
            x, _ = block.step(xp, numbers, state, x, dt)
            states += state
        return states

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        after: list[Scalar] = []
        for block, own, before in self._list_parts(theta, state):
            x, state_after = block.step(xp, own, before, x, dt)
            after += state_after
        return x, after

    def adapt_to(self, x: Numbers, dt: float) -> Self:
        blocks: list[AbstractBlock] = []
        for block in self.blocks:
            blocks.append(block.adapt_to(x, dt))
            x = _simulate_block(blocks[-1], blocks[-1].start(), x, dt)
        return self.with_parts(blocks=tuple(blocks))


@BLOCKS.register("sum")
class SummedBlocks(AbstractComposite):
    """Blocks of one output with the same inputs, and the sum of their outputs; `gain` weighs a block."""

    sign = "+"

    def check(self) -> None:
        super().check()
        if len({block.inputs for block in self.blocks}) > 1 or any(block.outputs != 1 for block in self.blocks):
            raise ParameterError(f"The blocks of `{self.text()}` must take the same signals and give one each.")

    @property
    def inputs(self) -> int:
        return self.blocks[0].inputs

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        return [s for block, numbers in self.split_numbers(theta) for s in block.rest(xp, numbers, x, dt)]

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        total: Scalar = 0.0
        after: list[Scalar] = []
        for block, own, before in self._list_parts(theta, state):
            (y,), state_after = block.step(xp, own, before, x, dt)
            total, after = total + y, [*after, *state_after]
        return (total,), after

    def adapt_to(self, x: Numbers, dt: float) -> Self:
        return self.with_parts(blocks=tuple(block.adapt_to(x, dt) for block in self.blocks))


@BLOCKS.register("feedback-loop")
class FeedbackLoop(AbstractComposite):
    """A block of one input and output with another, such as a hysteresis, in its feedback."""

    sign = "<"
    bounded = False

    blocks: tuple[AbstractBlock, ...] = part(
        "forward path, then feedback path", default=(TransferFunction(nb=2.0, nf=2.0), BoucWen())
    )
    fence_low: Number = param("1", "lower limit of the feedback", default=-WIDE)
    fence_high: Number = param("1", "upper limit of the feedback", default=WIDE)

    def check(self) -> None:
        if len(self.blocks) != 2 or any((block.inputs, block.outputs) != (1, 1) for block in self.blocks):
            raise ParameterError(
                f"A loop such as `[oe(2,2,1) < boucwen]` is made of two blocks of one input and one output, not of "
                f"`{self.text()}`."
            )

    def numbers(self) -> tuple[str, ...]:
        return (*super().numbers(), "gain")

    def states(self) -> int:
        return super().states() + 1

    @property
    def fixed(self) -> tuple[str, ...]:  # type: ignore[override]
        return (*super().fixed, "fence_low", "fence_high")

    def fixed_values(self) -> tuple[float, ...]:
        return (*super().fixed_values(), self.fence_low, self.fence_high)

    def with_fixed_values(self, values: Any) -> Self:
        return super().with_fixed_values(values).rebuilt({"fence_low": values[-2], "fence_high": values[-1]})

    @property
    def fenced(self) -> bool:  # type: ignore[override]
        return True

    def _limit(self, xp: Namespace, y: Scalar) -> Scalar:
        return xp.clip(y, self.fence_low, self.fence_high)

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        forward, back = self.blocks
        count = len(forward.numbers())

        def run(xp: Namespace, y: Scalar, u: Scalar, own: Column) -> tuple[list[Scalar], Scalar]:
            fed, numbers = self._limit(xp, y), own[count:-1]
            back_state = list(back.rest(xp, numbers, [fed], dt))
            (back_fed,), _ = back.step(xp, numbers, back_state, [fed], dt)
            entering = u - own[-1] * back_fed
            state = list(forward.rest(xp, own[:count], [entering], dt))
            (out,), _ = forward.step(xp, own[:count], state, [entering], dt)
            return [*state, *back_state], out

        def follow(xp: Namespace, state: Column, values: Column) -> Column:
            return [run(xp, state[0], values[0], values[1:])[1]]

        (first,), _ = forward.step(xp, theta[:count], forward.rest(xp, theta[:count], x, dt), x, dt)
        (y,) = fixed_point(xp, follow, [first], [x[0], *theta])
        return [*run(xp, y, x[0], theta)[0], y]

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        (forward, ahead, before), (back, own, back_state) = self._list_parts(theta, state)
        fed = state[-1]
        if getattr(forward, "nk", 0.0) >= 1.0:  # its output does not depend on what enters in this sample
            (fed,), _ = forward.step(xp, ahead, before, x, dt)
        (back_fed,), after = back.step(xp, own, back_state, [self._limit(xp, fed)], dt)
        (y,), moved = forward.step(xp, ahead, before, [x[0] - theta[-1] * back_fed], dt)
        return (y,), [*moved, *after, y]

    def adapt_to(self, x: Numbers, dt: float) -> Self:
        forward = self.blocks[0].adapt_to(x, dt)
        return self._adapt_back(forward, forward.start(), x, dt)

    def _adapt_back(self, forward: AbstractBlock, theta: Numbers, x: Numbers, dt: float) -> Self:
        y = _simulate_block(forward, theta, x, dt)
        y = y if np.all(np.isfinite(y)) else x
        return self.with_parts(blocks=(forward, self.blocks[1].adapt_to(y, dt)))

    def fence_in(self, theta: Numbers, states: Numbers, dt: float) -> Self:
        loop = super().fence_in(theta[:-1], states[:, :-1], dt)
        low, high = float(np.min(states[:, -1])), float(np.max(states[:, -1]))
        middle, half = 0.5 * (low + high), max(0.5 * (high - low), LEAST * max(abs(low), abs(high), LEAST))
        return loop.with_parts(fence_low=middle - BEYOND * half, fence_high=middle + BEYOND * half)

    def start(self) -> Numbers:
        return np.append(super().start(), 0.0)

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        return np.append(super().sample_parameters(rng, duration, dt), rng.uniform(-0.4, 2.0))

    def priors(self) -> tuple[Numbers, Numbers]:
        expected, weights = super().priors()
        return np.append(expected, 0.0), np.append(weights, 0.0)

    def twin(self) -> AbstractBlock | None:
        return self.blocks[0].twin()

    def as_linear(self, linear: AbstractBlock, theta: Numbers, x: Numbers, dt: float) -> tuple[Self, Numbers]:
        forward, own = self.blocks[0].as_linear(linear, theta, x, dt)
        loop = self._adapt_back(forward, own, x, dt)
        return loop, np.concatenate([own, loop.blocks[1].start(), [0.0]])

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        return [*super().describe_numbers(theta[:-1]), ("feedback gain", float(theta[-1]), "1")]


def _simulate_block(block: AbstractBlock, theta: Numbers, x: Numbers, dt: float) -> Numbers:
    numbers = [float(value) for value in theta]
    state = block.rest(floats, numbers, list(map(float, x[0])), dt)
    outputs = np.empty((len(x), block.outputs))
    for k, row in enumerate(x):
        outputs[k], state = block.step(floats, numbers, state, list(map(float, row)), dt)
    return outputs
