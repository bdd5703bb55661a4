"""Blocks that share signals: in series as one, summed, and one in the feedback of another.

    [a | b]   y = b(a(u))
    [a + b]   y = a(u) + b(u)
    [a < b]   y = a(u - g b(y))

With these and blocks side by side a chain is any graph of blocks: `[oe(2,2,1) < [poly3 + boucwen]]` is a mass
whose spring stiffens and yields. g is a free number, 0 at the start, where the loop is its forward path alone.
What is fed back is the output of this sample where the forward path delays (`nk` ≥ 1), so that nothing is to be
solved, else that of the sample before. In a fitted model it is limited to 1.5 times its range in the records
(`fence_in`): with a stable forward path the loop is then bounded for bounded inputs. See decision 039.
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
    """Blocks in series as one block, for a place among others."""

    sign = "|"

    def check(self) -> None:
        """Every block takes what the one before gives; `ParameterError` if one does not."""
        super().check()
        for before, after in zip(self.blocks, self.blocks[1:], strict=False):
            if before.outputs != after.inputs:
                raise ParameterError(
                    f"Block `{before.text()}` gives {before.outputs} signals, but `{after.text()}` takes "
                    f"{after.inputs}."
                )

    @property
    def inputs(self) -> int:
        """Return the number of inputs of the first block."""
        return self.blocks[0].inputs

    @property
    def outputs(self) -> int:
        """Return the number of outputs of the last block."""
        return self.blocks[-1].outputs

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        """Return every block at rest under what the one before gives."""
        found: list[Scalar] = []
        for block, own in self.split(theta, lambda one: len(one.numbers())):
            state = list(block.rest(xp, own, x, dt))
            x, _ = block.step(xp, own, state, x, dt)
            found += state
        return found

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Return a step of every block, one after the other."""
        after: list[Scalar] = []
        for block, own, before in self._list_parts(theta, state):
            x, held = block.step(xp, own, before, x, dt)
            after += held
        return x, after

    def adapt_to(self, x: Numbers, dt: float) -> Self:
        """Return every block adapted to what reaches it from the start."""
        made: list[AbstractBlock] = []
        for block in self.blocks:
            made.append(block.adapt_to(x, dt))
            x = _simulate_block(made[-1], made[-1].start(), x, dt)
        return self.with_parts(blocks=tuple(made))


@BLOCKS.register("sum")
class SummedBlocks(AbstractComposite):
    """Blocks of one output on the same signals, their outputs added; `gain` weighs one."""

    sign = "+"

    def check(self) -> None:
        """All take as many signals, and give one; `ParameterError` if they do not."""
        super().check()
        if len({block.inputs for block in self.blocks}) > 1 or any(block.outputs != 1 for block in self.blocks):
            raise ParameterError(f"The blocks of `{self.text()}` must take the same signals and give one each.")

    @property
    def inputs(self) -> int:
        """Return the number of inputs of each block."""
        return self.blocks[0].inputs

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        """Return every block at rest."""
        own = self.split(theta, lambda block: len(block.numbers()))
        return [s for block, numbers in own for s in block.rest(xp, numbers, x, dt)]

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Return a step of every block."""
        total: Scalar = 0.0
        after: list[Scalar] = []
        for block, own, before in self._list_parts(theta, state):
            (y,), held = block.step(xp, own, before, x, dt)
            total, after = total + y, [*after, *held]
        return (total,), after

    def adapt_to(self, x: Numbers, dt: float) -> Self:
        """Return every block adapted to the signals."""
        return self.with_parts(blocks=tuple(block.adapt_to(x, dt) for block in self.blocks))


@BLOCKS.register("feedback-loop")
class FeedbackLoop(AbstractComposite):
    """One input, one output: a block with another, such as a hysteresis, in its feedback."""

    sign = "<"
    bounded = False

    blocks: tuple[AbstractBlock, ...] = part(
        "the forward path, then what its output is fed back through",
        default=(TransferFunction(nb=2.0, nf=2.0), BoucWen()),
    )
    fence_low: Number = param("1", "least output that is fed back", default=-WIDE)
    fence_high: Number = param("1", "greatest output that is fed back", default=WIDE)

    def check(self) -> None:
        """Two blocks of one input and one output; `ParameterError` if they are not."""
        if len(self.blocks) != 2 or any((block.inputs, block.outputs) != (1, 1) for block in self.blocks):
            raise ParameterError(
                f"A loop such as `[oe(2,2,1) < boucwen]` is made of two blocks of one input and one output, not of "
                f"`{self.text()}`."
            )

    def numbers(self) -> tuple[str, ...]:
        """Return the names of the parameters of both blocks, then the feedback gain."""
        return (*super().numbers(), "gain")

    def states(self) -> int:
        """Return the number of states of both blocks and of the previous output."""
        return super().states() + 1

    @property
    def fixed(self) -> tuple[str, ...]:  # type: ignore[override]
        """Return the names of the fixed parameters of both blocks, then of the fence."""
        return (*super().fixed, "fence_low", "fence_high")

    def given(self) -> tuple[float, ...]:
        """Return the fixed parameters of both blocks, then the fence."""
        return (*super().given(), self.fence_low, self.fence_high)

    def with_given(self, values: Any) -> Self:
        """Return a twin with other fixed numbers."""
        shares = self.split(values, lambda block: len(block.fixed))
        made = tuple(block.with_given(own) for block, own in shares)
        return self.rebuilt({"blocks": made, "fence_low": values[-2], "fence_high": values[-1]})

    @property
    def fenced(self) -> bool:  # type: ignore[override]
        """Always: what is fed back must not be taken further than in the records."""
        return True

    def _limit(self, xp: Namespace, y: Scalar) -> Scalar:
        return xp.clip(y, self.fence_low, self.fence_high)

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        """Return the output y = a(u - g b(y)) of both at rest, by Newton's method from that without feedback."""
        forward, back = self.blocks
        count = len(forward.numbers())

        def run(xp: Namespace, y: Scalar, u: Scalar, own: Column) -> tuple[list[Scalar], Scalar]:
            fed, numbers = self._limit(xp, y), own[count:-1]
            held = list(back.rest(xp, numbers, [fed], dt))
            (back_fed,), _ = back.step(xp, numbers, held, [fed], dt)
            entering = u - own[-1] * back_fed
            state = list(forward.rest(xp, own[:count], [entering], dt))
            (out,), _ = forward.step(xp, own[:count], state, [entering], dt)
            return [*state, *held], out

        def follow(xp: Namespace, state: Column, given: Column) -> Column:
            return [run(xp, state[0], given[0], given[1:])[1]]

        (begun,), _ = forward.step(xp, theta[:count], forward.rest(xp, theta[:count], x, dt), x, dt)
        (y,) = fixed_point(xp, follow, [begun], [x[0], *theta])
        return [*run(xp, y, x[0], theta)[0], y]

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Feedback, then the forward path."""
        (forward, ahead, before), (back, own, held) = self._list_parts(theta, state)
        fed = state[-1]
        if getattr(forward, "nk", 0.0) >= 1.0:  # its output does not depend on what enters in this sample
            (fed,), _ = forward.step(xp, ahead, before, x, dt)
        (back_fed,), after = back.step(xp, own, held, [self._limit(xp, fed)], dt)
        (y,), moved = forward.step(xp, ahead, before, [x[0] - theta[-1] * back_fed], dt)
        return (y,), [*moved, *after, y]

    def adapt_to(self, x: Numbers, dt: float) -> Self:
        """Return the forward path to its input, the other to what that makes of it."""
        forward = self.blocks[0].adapt_to(x, dt)
        return self._adapt_back(forward, forward.start(), x, dt)

    def _adapt_back(self, forward: AbstractBlock, theta: Numbers, x: Numbers, dt: float) -> Self:
        y = _simulate_block(forward, theta, x, dt)
        y = y if np.all(np.isfinite(y)) else x
        return self.with_parts(blocks=(forward, self.blocks[1].adapt_to(y, dt)))

    def fence_in(self, theta: Numbers, states: Numbers, dt: float) -> Self:
        """Return both by their own states, and what is fed back by its range."""
        made = super().fence_in(theta[:-1], states[:, :-1], dt)
        low, high = float(np.min(states[:, -1])), float(np.max(states[:, -1]))
        middle, half = 0.5 * (low + high), max(0.5 * (high - low), LEAST * max(abs(low), abs(high), LEAST))
        return made.with_parts(fence_low=middle - BEYOND * half, fence_high=middle + BEYOND * half)

    def start(self) -> Numbers:
        """Return the start parameters of both blocks, with zero feedback."""
        return np.append(super().start(), 0.0)

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        """Draw parameters of both blocks, and a feedback that stiffens or, within bounds, softens."""
        return np.append(super().sample_parameters(rng, duration, dt), rng.uniform(-0.4, 2.0))

    def priors(self) -> tuple[Numbers, Numbers]:
        """Return the priors of both blocks."""
        expected, weights = super().priors()
        return np.append(expected, 0.0), np.append(weights, 0.0)

    def twin(self) -> AbstractBlock | None:
        """Return the linear system of the forward path."""
        return self.blocks[0].twin()

    def as_linear(self, linear: AbstractBlock, theta: Numbers, x: Numbers, dt: float) -> tuple[Self, Numbers]:
        """Return the forward path as that system, nothing fed back."""
        forward, own = self.blocks[0].as_linear(linear, theta, x, dt)
        made = self._adapt_back(forward, own, x, dt)
        return made, np.concatenate([own, made.blocks[1].start(), [0.0]])

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        """Return the parameters of both blocks, then the feedback gain."""
        return [*super().describe_numbers(theta[:-1]), ("feedback gain", float(theta[-1]), "1")]


def _simulate_block(block: AbstractBlock, theta: Numbers, x: Numbers, dt: float) -> Numbers:
    """Return the outputs of a block alone, from rest, on floats."""
    own = [float(value) for value in theta]
    state = block.rest(floats, own, list(map(float, x[0])), dt)
    made = np.empty((len(x), block.outputs))
    for k, row in enumerate(x):
        made[k], state = block.step(floats, own, state, list(map(float, row)), dt)
    return made
