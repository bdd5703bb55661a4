"""The contract of every block of a dynamic model: signals in, signals out, sample by sample.

A block has a structure (orders, numbers of units), fixed numbers (the range of its input, set
from a record before any fit) and free numbers θ, which a fit moves without bounds: a time
constant is held as its logarithm, weights that must be positive as a softmax, so that whatever
a fit proposes is a model that can be simulated. `step` is a straight-line kernel: it runs on
plain floats, and traced in C with all its partial derivatives.

A block is one file: what it computes, its free numbers, and values to start from.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, Parametrised, option, param
from martensite.base.registry import Registry
from martensite.kernels.namespace import Namespace, Scalar

BLOCKS: Registry[AbstractBlock] = Registry("block", "martensite.identify.blocks")
Column = Sequence[Scalar]
Numbers: TypeAlias = NDArray[Any]
"""Arrays of floats, or of what counts them."""

MAX_COUNT = 10_000
"""Largest count of a block parameter (order, units, knots); tracing time grows with the count."""


class AbstractBlock(Parametrised):
    """Interface of a block. Its declared parameters are structure, unless named in `fixed`."""

    short: ClassVar[str] = ""
    """Name of the block in the text of a chain, such as `poly` in `poly2`."""
    shape: ClassVar[tuple[str, ...]] = ()
    """The declared parameters that are written in brackets, in their order; a choice last."""
    fixed: ClassVar[tuple[str, ...]] = ()
    """The declared parameters that `adapted` sets from a record."""
    linear: ClassVar[bool] = False
    """True for a linear dynamic system."""
    bounded: ClassVar[bool] = True
    """False if some free numbers make it grow without bound."""
    fenced: ClassVar[bool] = False
    """True if nonlinear terms must stay within the range of the records; see `fence_in`."""

    def check(self) -> None:
        """Raise `ParameterError` unless the numbers in the text of the block are whole, and at most `MAX_COUNT`."""
        for name in self.shape:
            value = getattr(self, name)
            if isinstance(value, float) and value != int(value):
                raise ParameterError(
                    f"Parameter `{name}` of `{self.registered_name}` must be a whole number, but is {value:g}."
                )
            if isinstance(value, float) and value > MAX_COUNT:
                raise ParameterError(
                    f"Parameter `{name}` of `{self.registered_name}` must be at most {MAX_COUNT:,}, but is {value:g}."
                )

    @property
    def inputs(self) -> int:
        """Return the number of signals it takes."""
        return 1

    @property
    def outputs(self) -> int:
        """Return the number of signals it gives."""
        return 1

    def numbers(self) -> tuple[str, ...]:
        """Return the names of the free numbers θ."""
        return ()

    def states(self) -> int:
        """Return the number of states that the block stores from one sample to the next."""
        return 0

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        """Return the state at rest under a constant input."""
        return ()

    @abstractmethod
    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Return the outputs of this sample and the state for the next, `dt` [s] later."""

    def adapt_to(self, x: Numbers, dt: float) -> Self:
        """Return the block with its fixed numbers set for an input of shape (samples, inputs)."""
        return self

    def fence_in(self, theta: Numbers, states: Numbers, dt: float) -> Self:
        """Return the block whose nonlinear terms go no further than in records; itself if they are bounded as they are.

        Args:
            theta: its free numbers.
            states: those that it had in the records, shape (samples, states).
            dt: sample time [s].
        """
        return self

    def start(self) -> Numbers:
        """Return the values of the free numbers to begin with: the plainest behaviour."""
        return np.zeros(len(self.numbers()))

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        """Return random values to begin with, for records of some duration [s]."""
        return self.start()

    def twin(self) -> AbstractBlock | None:
        """Return the linear block without the nonlinear terms; the block itself if it is linear.

        None for a block without linear dynamics. A search begins at the best linear block.
        """
        return None

    def as_linear(self, linear: AbstractBlock, theta: Numbers, x: Numbers, dt: float) -> tuple[Self, Numbers]:
        """Return the block, and free numbers with which it runs as a linear one, nonlinear terms 0.

        Args:
            linear: what `twin` gives.
            theta: its free numbers.
            x: what enters, shape (samples, inputs): fixed numbers may suit it.
            dt: sample time [s].
        """
        return self, theta

    def priors(self) -> tuple[Numbers, Numbers]:
        """Return the expected values of the free numbers, and 1/σ of each; 0 for those of which none is known.

        A fit counts (θ - expected)/σ as one more residual each.
        """
        return self.start(), np.zeros(len(self.numbers()))

    def gains(self) -> tuple[str, ...]:
        """For each output the free number that it is proportional to; empty where there is none.

        A search begins with those that suit the record.
        """
        return ("",) * self.outputs

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        """Return the name, value and unit of what the free numbers mean, for people to read."""
        return [(name, float(value), "1") for name, value in zip(self.numbers(), theta, strict=True)]

    def text(self) -> str:
        """Return the block as it is written in the text of a chain."""
        told = [getattr(self, name) for name in self.shape]
        for name in reversed(self.shape):  # what is read goes by place: only the last may be left out
            if not isinstance(told[-1], str) or told[-1] != self.declarations[name].default:
                break
            told.pop()
        inner = ",".join(v if isinstance(v, str) else f"{v:g}" for v in told)
        return f"{self.short}({inner})" if inner else self.short

    def given(self) -> tuple[float, ...]:
        """Return the fixed numbers, in the order of `fixed`."""
        return tuple(getattr(self, name) for name in self.fixed)

    def with_given(self, values: Sequence[Any]) -> Self:
        """Return a twin with other fixed numbers, unchecked: for tracing kernels."""
        return self.rebuilt(dict(zip(self.fixed, values, strict=True)))

    def structure(self) -> tuple[Any, ...]:
        """Return all that makes it another program: everything but the fixed and the free numbers."""
        kept = (n for n in self.declarations if n not in self.fixed)
        return type(self), tuple((name, getattr(self, name)) for name in kept)


class AbstractRanged(AbstractBlock):
    """A block that is scaled by the range of its input."""

    fixed = ("low", "high")

    low: Number = param("1", "lower end of the range of the input", default=-1.0)
    high: Number = param("1", "upper end of the range of the input", default=1.0)

    def adapt_to(self, x: Numbers, dt: float) -> Self:
        """Takes the range of the input."""
        low, high = float(np.min(x)), float(np.max(x))
        spread = high - low if high > low else max(abs(high), 1.0)
        return self.with_parts(low=low, high=low + spread)

    @property
    def half(self) -> float:
        """Return half the range of the input: what 1 on its scale is."""
        return 0.5 * (self.high - self.low)

    @property
    def middle(self) -> float:
        """Return the middle of the range."""
        return 0.5 * (self.high + self.low)

    def unit(self, x: Scalar) -> Scalar:
        """Return the input on a scale where its range is -1 to 1."""
        return (2.0 * x - self.low - self.high) / (self.high - self.low)


class AbstractStatic(AbstractRanged):
    """A block without memory: one signal in, one out."""

    offset: str = option("whether the output at zero input is free; else it is 0", "yes", "no", default="yes")

    @abstractmethod
    def value(self, xp: Namespace, theta: Column, x: Scalar) -> Scalar:
        """Return the output."""

    @abstractmethod
    def line(self, slope: float, offset: float) -> Numbers:
        """Return the free numbers that make it a straight line, as well as it can be one."""

    def scale_departure(self, departure: Numbers, factor: float) -> Numbers:
        """Return a departure from a line with its outputs times a factor.

        All numbers unless the block says otherwise: those of position and width do not scale.
        """
        return departure * factor

    def start(self) -> Numbers:
        """Return the identity."""
        return self.line(1.0, 0.0)

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Return the output of this sample."""
        return (self.value(xp, theta, x[0]),), ()
