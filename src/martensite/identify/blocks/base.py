"""Interface of the blocks of a dynamic model: signals in, signals out, sample by sample.

A block has a structure (orders, numbers of units), fixed numbers (the range of its input, set from a record before a
fit) and free numbers θ, which a fit moves without bounds: time constants as logarithms, positive weights as a softmax,
so that any values can be simulated. `step` is a straight-line kernel that runs on floats, and in C with all its partial
derivatives.
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

MAX_COUNT = 10_000
"""Largest count of a block parameter (order, units, knots), which limits the tracing time."""


class AbstractBlock(Parametrised):
    """Interface of a block. Its declared parameters are structure, unless named in `fixed`."""

    short: ClassVar[str] = ""
    """Name in the text of a chain, such as `poly` in `poly2`."""
    shape: ClassVar[tuple[str, ...]] = ()
    """Declared parameters in brackets, in order; a choice last."""
    fixed: ClassVar[tuple[str, ...]] = ()
    """Declared parameters that `adapt_to` sets from a record."""
    linear: ClassVar[bool] = False
    """True for a linear dynamic system."""
    bounded: ClassVar[bool] = True
    """False if some free numbers give unbounded outputs."""
    fenced: ClassVar[bool] = False
    """True if nonlinear terms must stay within the range of the records; see `fence_in`."""

    def check(self) -> None:
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
        """Return the number of inputs."""
        return 1

    @property
    def outputs(self) -> int:
        """Return the number of outputs."""
        return 1

    def numbers(self) -> tuple[str, ...]:
        """Return the names of the free numbers θ."""
        return ()

    def states(self) -> int:
        """Return the number of states."""
        return 0

    def rest(self, xp: Namespace, theta: Column, x: Column, dt: Scalar) -> Column:
        """Return the steady state under a constant input."""
        return ()

    @abstractmethod
    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        """Return the outputs of this sample, and the state `dt` [s] later."""

    def adapt_to(self, x: Numbers, dt: float) -> Self:
        """Return the block with its fixed numbers set for an input of shape (samples, inputs)."""
        return self

    def fence_in(self, theta: Numbers, states: Numbers, dt: float) -> Self:
        """Return the block with nonlinear terms limited to their range in the records; unchanged if it is bounded.

        Args:
            theta: free numbers.
            states: states in the records, shape (samples, states).
            dt: sample time [s].
        """
        return self

    def start(self) -> Numbers:
        """Return initial values of the free numbers with the simplest behaviour."""
        return np.zeros(len(self.numbers()))

    def sample_parameters(self, rng: np.random.Generator, duration: float, dt: float) -> Numbers:
        """Return random initial values for records of a duration [s]."""
        return self.start()

    def twin(self) -> AbstractBlock | None:
        """Return the linear block without nonlinear terms, where a search begins; None without linear dynamics."""
        return None

    def as_linear(self, linear: AbstractBlock, theta: Numbers, x: Numbers, dt: float) -> tuple[Self, Numbers]:
        """Return the block, and free numbers with which it equals a linear block.

        Args:
            linear: block from `twin`.
            theta: its free numbers.
            x: input, shape (samples, inputs), for the fixed numbers.
            dt: sample time [s].
        """
        return self, theta

    def priors(self) -> tuple[Numbers, Numbers]:
        """Return the expected values of the free numbers, and 1/σ of each; 0 without a prior.

        A fit adds the residual (θ - expected)/σ of each.
        """
        return self.start(), np.zeros(len(self.numbers()))

    def gains(self) -> tuple[str, ...]:
        """Return the free number that each output is proportional to; empty without one. A search fits these first."""
        return ("",) * self.outputs

    def describe_numbers(self, theta: Numbers) -> list[tuple[str, float, str]]:
        """Return name, value and unit of the physical meaning of the free numbers."""
        return [(name, float(value), "1") for name, value in zip(self.numbers(), theta, strict=True)]

    def text(self) -> str:
        """Return the block in the text of a chain."""
        values = [getattr(self, name) for name in self.shape]
        for name in reversed(self.shape):  # a default may be left out at the end only
            if not isinstance(values[-1], str) or values[-1] != self.declarations[name].default:
                break
            values.pop()
        inner = ",".join(v if isinstance(v, str) else f"{v:g}" for v in values)
        return f"{self.short}({inner})" if inner else self.short

    def fixed_values(self) -> tuple[float, ...]:
        """Return the fixed numbers, in the order of `fixed`."""
        return tuple(getattr(self, name) for name in self.fixed)

    def with_fixed_values(self, values: Sequence[Any]) -> Self:
        """Return the block with other fixed numbers, unchecked, for tracing."""
        return self.rebuilt(dict(zip(self.fixed, values, strict=True)))

    def structure(self) -> tuple[Any, ...]:
        """Return all that determines the program: everything but the fixed and free numbers."""
        names = (n for n in self.declarations if n not in self.fixed)
        return type(self), tuple((name, getattr(self, name)) for name in names)


class AbstractRanged(AbstractBlock):
    """A block that is scaled by the range of its input."""

    fixed = ("low", "high")

    low: Number = param("1", "lower end of the range of the input", default=-1.0)
    high: Number = param("1", "upper end of the range of the input", default=1.0)

    def adapt_to(self, x: Numbers, dt: float) -> Self:
        low, high = float(np.min(x)), float(np.max(x))
        spread = high - low if high > low else max(abs(high), 1.0)
        return self.with_parts(low=low, high=low + spread)

    @property
    def half(self) -> float:
        """Return half the range of the input."""
        return 0.5 * (self.high - self.low)

    @property
    def middle(self) -> float:
        """Return the middle of the range."""
        return 0.5 * (self.high + self.low)

    def unit(self, x: Scalar) -> Scalar:
        """Return the input on a scale where its range is -1 to 1."""
        return (2.0 * x - self.low - self.high) / (self.high - self.low)


class AbstractStatic(AbstractRanged):
    """A block without memory, with one input and one output."""

    offset: str = option("free output at zero input; `no`: it is 0", "yes", "no", default="yes")

    @abstractmethod
    def value(self, xp: Namespace, theta: Column, x: Scalar) -> Scalar:
        """Return the output."""

    @abstractmethod
    def line(self, slope: float, offset: float) -> Numbers:
        """Return the free numbers of the nearest straight line."""

    def scale_departure(self, departure: Numbers, factor: float) -> Numbers:
        """Return a departure from a line with its outputs multiplied; positions and widths do not scale."""
        return departure * factor

    def start(self) -> Numbers:
        return self.line(1.0, 0.0)

    def step(self, xp: Namespace, theta: Column, state: Column, x: Column, dt: Scalar) -> tuple[Column, Column]:
        return (self.value(xp, theta, x[0]),), ()
