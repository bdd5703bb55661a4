"""Composite blocks, and blocks in parallel on separate signals: `[poly2 & unit]`.

Inputs, outputs, states, free and fixed parameters of the blocks are concatenated. So a
chain of several signals has a static block, a delay or a hysteresis for each of them.
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
    """Blocks as one, written between square brackets: their states and numbers one after the other."""

    sign: ClassVar[str]
    """Sign between the blocks in the text form."""
    blocks: tuple[AbstractBlock, ...] = part("the blocks", default=(UnitGain(), UnitGain()))

    def check(self) -> None:
        """There are blocks; `ParameterError` if there is none."""
        if not self.blocks:
            raise ParameterError(f"A block `{self.registered_name}` needs at least one block inside.")

    @abstractmethod
    def adapt_to(self, x: Numbers, dt: float) -> Self:
        """Return every block adapted to what reaches it."""

    def numbers(self) -> tuple[str, ...]:
        """Return the names of the parameters of all blocks, prefixed by the place of the block."""
        return tuple(f"{place}.{n}" for place, b in self._place_blocks for n in b.numbers())

    def states(self) -> int:
        """Return the number of states of all blocks."""
        return sum(block.states() for block in self.blocks)

    @property
    def _place_blocks(self) -> Iterator[tuple[int, AbstractBlock]]:
        return enumerate(self.blocks, start=1)

    def split(self, column: Any, count: Callable[[AbstractBlock], int]) -> Iterator[tuple[AbstractBlock, Any]]:
        """Yield the blocks, each with its share of a column, of which it has a certain count."""
        first = 0
        for block in self.blocks:
            last = first + count(block)
            yield block, column[first:last]
            first = last

    def _list_parts(self, theta: Column, state: Column) -> list[tuple[AbstractBlock, Column, Column]]:
        """Return the blocks, each with its free numbers and its state."""
        own = self.split(theta, lambda block: len(block.numbers()))
        held = self.split(state, lambda block: block.states())
        return [(block, numbers, before) for (block, numbers), (_, before) in zip(own, held, strict=True)]

    @property
    def fenced(self) -> bool:  # type: ignore[override]
        """Return whether one of the blocks has this property."""
        return any(block.fenced for block in self.blocks)

    def fence_in(self, theta: Numbers, states: Numbers, dt: float) -> Self:
        """Return every block by its own states."""
        own = self.split(theta, lambda block: len(block.numbers()))
        held = self.split(states.T, lambda block: block.states())
        both = zip(own, held, strict=True)
        return self.with_parts(blocks=tuple(b.fence_in(numbers, seen.T, dt) for (b, numbers), (_, seen) in both))

    def start(self) -> Numbers:
        """Return the start parameters of all blocks."""
        return np.concatenate([np.zeros(0), *(block.start() for block in self.blocks)])

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        """Draw parameters of all blocks."""
        drawn = (block.sample_parameters(rng, duration, dt) for block in self.blocks)
        return np.concatenate([np.zeros(0), *drawn])

    def priors(self) -> tuple[Numbers, Numbers]:
        """Return the priors of all blocks."""
        expected, weights = zip(*(block.priors() for block in self.blocks), strict=True)
        return np.concatenate(expected), np.concatenate(weights)

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        """Return the parameters of all blocks, prefixed by the place of the block."""
        shares = self.split(theta, lambda block: len(block.numbers()))
        return [
            (f"{place}.{name}", value, unit)
            for place, (block, own) in enumerate(shares, start=1)
            for name, value, unit in block.describe_numbers(own)
        ]

    def text(self) -> str:
        """Return the blocks between square brackets."""
        return f"[{f' {self.sign} '.join(block.text() for block in self.blocks)}]"

    @property
    def fixed(self) -> tuple[str, ...]:  # type: ignore[override]
        """Return the fixed numbers of all blocks, with the place of each."""
        return tuple(f"{place}.{name}" for place, b in self._place_blocks for name in b.fixed)

    def given(self) -> tuple[float, ...]:
        """Return the fixed parameters of all blocks."""
        return tuple(value for block in self.blocks for value in block.given())

    def with_given(self, values: Sequence[Any]) -> Self:
        """Return every block with its own."""
        shares = self.split(values, lambda block: len(block.fixed))
        return self.rebuilt({"blocks": tuple(block.with_given(own) for block, own in shares)})

    def structure(self) -> tuple[Any, ...]:
        """Return the structures of all blocks."""
        return type(self), tuple(block.structure() for block in self.blocks)


@BLOCKS.register("side-by-side")
class SideBySide(AbstractComposite):
    """Any blocks, the signals of one after those of another."""

    sign = "&"

    @property
    def inputs(self) -> int:
        """Return the number of inputs of all blocks."""
        return sum(block.inputs for block in self.blocks)

    @property
    def outputs(self) -> int:
        """Return the number of outputs of all blocks."""
        return sum(block.outputs for block in self.blocks)

    def _shares(self, theta: Column, x: Column) -> list[tuple[AbstractBlock, Column, Column]]:
        own = self.split(theta, lambda block: len(block.numbers()))
        signals = self.split(x, lambda block: block.inputs)
        return [(b, numbers, taken) for (b, numbers), (_, taken) in zip(own, signals, strict=True)]

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        """Return every block at rest."""
        shares = self._shares(theta, x)
        return [s for block, own, taken in shares for s in block.rest(xp, own, taken, dt)]

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Return a step of every block."""
        held = self.split(state, lambda block: block.states())
        outputs: list[Scalar] = []
        after: list[Scalar] = []
        for (block, own, taken), (_, before) in zip(self._shares(theta, x), held, strict=True):
            y, s = block.step(xp, own, before, taken, dt)
            outputs += y
            after += s
        return outputs, after

    def adapt_to(self, x: Numbers, dt: float) -> Self:
        """Return every block adapted to its own signals."""
        columns = self.split(x.T, lambda block: block.inputs)
        return self.with_parts(blocks=tuple(block.adapt_to(own.T, dt) for block, own in columns))

    def gains(self) -> tuple[str, ...]:
        """Return the names of the gains of all blocks, prefixed by the place of the block."""
        named = ((place, name) for place, block in self._place_blocks for name in block.gains())
        return tuple(f"{place}.{name}" if name else "" for place, name in named)
