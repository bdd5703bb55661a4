"""Composite blocks, and blocks in parallel on separate signals: `[poly2 & unit]`.

Inputs, outputs, states, free and fixed parameters of the blocks are concatenated, so a chain of several signals can
have a static block, a delay or a hysteresis for each.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from typing import Any, ClassVar, Self

import numpy as np

from martensite.base.errors import ParameterError
from martensite.base.parameters import part
from martensite.identify.blocks.base import BLOCKS, AbstractBlock, Column, Numbers
from martensite.identify.blocks.gain import UnitGain
from martensite.kernels.namespace import Namespace, Scalar


class AbstractComposite(AbstractBlock):
    """Blocks as one block, in square brackets, with concatenated states and numbers."""

    sign: ClassVar[str]
    """Sign between the blocks in the text."""
    blocks: tuple[AbstractBlock, ...] = part("the blocks", default=(UnitGain(), UnitGain()))

    def check(self) -> None:
        if not self.blocks:
            raise ParameterError(f"A block `{self.registered_name}` needs at least one block inside.")

    @abstractmethod
    def adapt_to(self, x: Numbers, dt: float) -> Self:
        """Return every block adapted to its signals."""

    def numbers(self) -> tuple[str, ...]:
        return tuple(f"{place}.{n}" for place, b in self._place_blocks for n in b.numbers())

    def states(self) -> int:
        return sum(block.states() for block in self.blocks)

    @property
    def _place_blocks(self) -> Iterator[tuple[int, AbstractBlock]]:
        return enumerate(self.blocks, start=1)

    def split(self, column: Any, count: Callable[[AbstractBlock], int]) -> Iterator[tuple[AbstractBlock, Any]]:
        """Yield the blocks, each with its part of a column, whose length `count` returns."""
        first = 0
        for block in self.blocks:
            last = first + count(block)
            yield block, column[first:last]
            first = last

    def split_numbers(self, theta: Any) -> Iterator[tuple[AbstractBlock, Any]]:
        """Yield the blocks with their free numbers."""
        return self.split(theta, lambda block: len(block.numbers()))

    def _list_parts(self, theta: Column, state: Column) -> list[tuple[AbstractBlock, Column, Column]]:
        """Return the blocks with their free numbers and states."""
        states = self.split(state, lambda block: block.states())
        numbers_of = self.split_numbers(theta)
        return [(block, numbers, before) for (block, numbers), (_, before) in zip(numbers_of, states, strict=True)]

    @property
    def fenced(self) -> bool:  # type: ignore[override]
        return any(block.fenced for block in self.blocks)

    def fence_in(self, theta: Numbers, states: Numbers, dt: float) -> Self:
        numbers_of = self.split_numbers(theta)
        parts_of_states = self.split(states.T, lambda block: block.states())
        both = zip(numbers_of, parts_of_states, strict=True)
        return self.with_parts(blocks=tuple(b.fence_in(numbers, part.T, dt) for (b, numbers), (_, part) in both))

    def start(self) -> Numbers:
        return np.concatenate([np.zeros(0), *(block.start() for block in self.blocks)])

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        parameter_sets = (block.sample_parameters(rng, duration, dt) for block in self.blocks)
        return np.concatenate([np.zeros(0), *parameter_sets])

    def priors(self) -> tuple[Numbers, Numbers]:
        expected, weights = zip(*(block.priors() for block in self.blocks), strict=True)
        return np.concatenate(expected), np.concatenate(weights)

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        return [
            (f"{place}.{name}", value, unit)
            for place, (block, own) in enumerate(self.split_numbers(theta), start=1)
            for name, value, unit in block.describe_numbers(own)
        ]

    def text(self) -> str:
        return f"[{f' {self.sign} '.join(block.text() for block in self.blocks)}]"

    @property
    def fixed(self) -> tuple[str, ...]:  # type: ignore[override]
        return tuple(f"{place}.{name}" for place, b in self._place_blocks for name in b.fixed)

    def fixed_values(self) -> tuple[float, ...]:
        return tuple(value for block in self.blocks for value in block.fixed_values())

    def with_fixed_values(self, values: Sequence[Any]) -> Self:
        shares = self.split(values, lambda block: len(block.fixed))
        return self.rebuilt({"blocks": tuple(block.with_fixed_values(own) for block, own in shares)})

    def structure(self) -> tuple[Any, ...]:
        return type(self), tuple(block.structure() for block in self.blocks)


@BLOCKS.register("side-by-side")
class SideBySide(AbstractComposite):
    """Any blocks on separate signals."""

    sign = "&"

    @property
    def inputs(self) -> int:
        return sum(block.inputs for block in self.blocks)

    @property
    def outputs(self) -> int:
        return sum(block.outputs for block in self.blocks)

    def _shares(self, theta: Column, x: Column) -> list[tuple[AbstractBlock, Column, Column]]:
        rows = zip(self.split_numbers(theta), self.split(x, lambda block: block.inputs), strict=True)
        return [(block, numbers, signals) for (block, numbers), (_, signals) in rows]

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        shares = self._shares(theta, x)
        return [s for block, own, taken in shares for s in block.rest(xp, own, taken, dt)]

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        block_states = self.split(state, lambda block: block.states())
        outputs: list[Scalar] = []
        after: list[Scalar] = []
        for (block, own, taken), (_, before) in zip(self._shares(theta, x), block_states, strict=True):
            y, s = block.step(xp, own, before, taken, dt)
            outputs += y
            after += s
        return outputs, after

    def adapt_to(self, x: Numbers, dt: float) -> Self:
        columns = self.split(x.T, lambda block: block.inputs)
        return self.with_parts(blocks=tuple(block.adapt_to(own.T, dt) for block, own in columns))

    def gains(self) -> tuple[str, ...]:
        named = ((place, name) for place, block in self._place_blocks for name in block.gains())
        return tuple(f"{place}.{name}" if name else "" for place, name in named)
