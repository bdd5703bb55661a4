"""A dynamic model: blocks in series with their numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from martensite.base.errors import InputError, ParameterError
from martensite.identify.blocks.base import AbstractBlock, Numbers
from martensite.identify.chains.engine import ChainEngine
from martensite.identify.chains.native_source import Taps
from martensite.signals.sampling.sampled import Sampled


class RecordStart(NamedTuple):
    """Start of a record in the fit."""

    name: str
    kind: str
    state: tuple[float, ...] = ()
    """Estimated state at the first sample, else empty."""


@dataclass(frozen=True, eq=False)
class Chain:
    """Blocks in series with values of their free numbers, at one sample time.

    static | linear is a Hammerstein model, linear | static a Wiener model; any order is possible. Linear blocks are
    stable by their parameters.
    """

    blocks: tuple[AbstractBlock, ...]
    theta: Numbers
    interval: float
    """Sample time [s]."""
    input_names: tuple[str, ...] = ("u",)
    output_names: tuple[str, ...] = ("y",)
    units: dict[str, str] = field(default_factory=dict[str, str])
    taps: Taps | None = None
    """Outputs as (block, its output); default: the outputs of the last block."""
    name: str = "model"
    starts: Mapping[str, RecordStart] = field(default_factory=dict[str, RecordStart])
    """Starts of the records of the fit, by hash (`Sampled.hash`)."""
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict[str, tuple[float, float]])
    """Smallest and largest value of every signal in these records; empty if unknown."""

    def __post_init__(self) -> None:
        if not self.blocks:
            raise ParameterError("A chain needs at least one block.")
        for before, after in zip(self.blocks, self.blocks[1:], strict=False):
            if before.outputs != after.inputs:
                raise ParameterError(
                    f"Block `{before.text()}` gives {before.outputs} signals, but `{after.text()}` "
                    f"after it takes {after.inputs}."
                )
        count = sum(len(block.numbers()) for block in self.blocks)
        if len(self.theta) != count:
            raise ParameterError(f"Chain `{self.text()}` has {count} free numbers, but {len(self.theta)} are given.")

    def text(self) -> str:
        """Return the chain as text, such as `poly2 | oe(3,3,1) | pwl10`."""
        return " | ".join(block.text() for block in self.blocks)

    @cached_property
    def engine(self) -> ChainEngine:
        """Return the engine that simulates the chain."""
        return ChainEngine(self.blocks, self.interval, self.taps)

    @property
    def inputs(self) -> int:
        """Return the number of inputs."""
        return self.blocks[0].inputs

    def names(self) -> list[str]:
        """Return the names of all free numbers, with the number of their block."""
        return [f"{i + 1}.{n}" for i, block in enumerate(self.blocks) for n in block.numbers()]

    def split(self, theta: Numbers | None = None) -> list[Numbers]:
        """Return the free numbers by block."""
        counts = [len(block.numbers()) for block in self.blocks]
        values = self.theta if theta is None else theta
        return np.split(values, np.cumsum(counts)[:-1])

    def with_theta(self, theta: Numbers) -> Chain:
        """Return the chain with other parameters."""
        return replace(self, theta=np.array(theta, dtype=float))

    def with_records(self, starts: Mapping[str, RecordStart], ranges: Mapping[str, tuple[float, float]]) -> Chain:
        """Return the chain with starts and ranges of the records of its fit."""
        return replace(self, starts=starts, ranges=ranges)

    def simulate(self, inputs: Numbers | Sampled, state: Numbers | None = None) -> Numbers:
        """Return the outputs, shape (samples, outputs), of a free run.

        The run begins in the given state, or as in the fit for a record of the fit, else in the steady state under the
        first input. `record_starts.find_start` finds the start of other records.

        Raises:
            InputError: the number of inputs or the sample time does not fit.
        """
        u = self._check_inputs(inputs)
        if state is None and isinstance(inputs, Sampled) and self.starts:
            start = self.starts.get(inputs.hash)
            state = None if start is None else self.restore_state(start)
        return self.engine.simulate(self.theta, u, None if state is None else state.copy())

    def restore_state(self, start: RecordStart) -> Numbers | None:
        """Return the state at the first sample of a record of the fit; None for the steady state."""
        if start.kind == "rest":
            return None
        return np.array(start.state) if start.state else np.zeros(self.engine.plan.states)

    def _check_inputs(self, inputs: Numbers | Sampled) -> Numbers:
        if isinstance(inputs, Sampled):
            if abs(inputs.interval / self.interval - 1.0) > 1e-6:
                raise InputError(
                    f"Model `{self.name}` has the sample time {self.interval:.6g} s, but record "
                    f"`{inputs.name}` {inputs.interval:.6g} s; resample one of them."
                )
            inputs = inputs.inputs
        u = np.asarray(inputs, dtype=float)
        u = u[:, None] if u.ndim == 1 else u
        if u.shape[1] != self.inputs:
            raise InputError(f"Model `{self.name}` takes {self.inputs} inputs, not {u.shape[1]}.")
        return u

    def before(self, block: int, inputs: Numbers | Sampled) -> Numbers:
        """Return the input of a block, shape (samples, inputs of the block)."""
        u = self._check_inputs(inputs)
        if block == 0:
            return u
        theta = np.concatenate([np.zeros(0), *self.split()[:block]])
        return ChainEngine(self.blocks[:block], self.interval).simulate(theta, u)

    def then(self, other: Chain) -> Chain:
        """Return this model in series with another; raise `InputError` for different sample times."""
        if abs(other.interval / self.interval - 1.0) > 1e-6:
            raise InputError(
                f"Models in series need one sample time, but `{self.name}` has "
                f"{self.interval:.6g} s and `{other.name}` {other.interval:.6g} s."
            )
        taps = other.taps and tuple((k + len(self.blocks), i) for k, i in other.taps)
        return Chain(
            self.blocks + other.blocks,
            np.concatenate([self.theta, other.theta]),
            self.interval,
            self.input_names,
            other.output_names,
            {**self.units, **other.units},
            taps,
            f"{self.name} | {other.name}",
            ranges={**other.ranges, **self.ranges},
        )


def build_untrained(blocks: Sequence[AbstractBlock], record: Sampled, taps: Taps | None = None) -> Chain:
    """Return a chain for a record, with each block adapted to its input."""
    adapted: list[AbstractBlock] = []
    x, theta = record.inputs, np.zeros(0)
    for block in blocks:
        block = block.adapt_to(x, record.interval)
        adapted.append(block)
        numbers = block.start()
        x = ChainEngine([block], record.interval).simulate(numbers, x)
        theta = np.concatenate([theta, numbers])
    return Chain(
        tuple(adapted),
        theta,
        record.interval,
        record.input_names,
        record.output_names,
        dict(record.units),
        taps,
        record.name,
    )
