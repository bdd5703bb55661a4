"""Grids and samples of the unit cube, computed from any run on.

    grid               every combination of the levels of all axes; the last axis varies fastest
    monte-carlo        independent random numbers (PCG64)
    latin-hypercube    every axis has as many strata as there are runs, and each is used once (McKay, Beckman and
                       Conover (1979)); their order needs 4 bytes per run and axis
    sobol              a scrambled Sobol' sequence, which fills space evenly (Owen (1998); SciPy)
    saltelli           blocks of runs for Sobol' indices, in the order of SALib

The design saltelli uses two independent samples A and B of N points, the first and second half of the coordinates of a
scrambled Sobol' sequence. Block n has point n of A, then for every axis that point with the coordinate of B, then point
n of B: d + 2 runs (Saltelli et al. (2010), Comput. Phys. Commun. 181, radial design without second order). Use a power
of 2 for the last two designs.
"""

from __future__ import annotations

import math
import warnings
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from threading import Lock
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import ParameterError
from martensite.base.interfaces import override
from martensite.base.registry import Registry
from martensite.search.free_numbers import FreeNumber
from martensite.signals.sampling.sampled import Numbers

MOST_RUNS = 1_000_000_000


@dataclass(frozen=True)
class AbstractDesign(ABC):
    """Runs of a sweep."""

    registered_name: ClassVar[str] = ""
    count: int | None = None
    """Requested number of samples; None on a grid."""
    seed: int = 0

    def __post_init__(self) -> None:
        """Raise `ParameterError` for a negative seed."""
        if self.seed < 0:
            raise ParameterError(f"A seed is 0 or above, but is {self.seed}.")

    @abstractmethod
    def size(self, axes: Sequence[FreeNumber]) -> int:
        """Return the number of runs; raise `ParameterError` for too many."""

    @abstractmethod
    def values(self, axes: Sequence[FreeNumber], first: int, count: int) -> Numbers:
        """Return the parameters of `count` runs from `first` on, (count, axes), in SI."""


class AbstractSample(AbstractDesign):
    """Sample of the unit cube, mapped to the axes by their quantiles."""

    def __post_init__(self) -> None:
        """Raise `ParameterError` for a missing or invalid number of runs."""
        super().__post_init__()
        if self.count is None or not 1 <= self.count <= MOST_RUNS:
            raise ParameterError(
                f"`{self.registered_name}` needs how many runs, such as `{self.registered_name}:1024`."
            )

    @override
    def size(self, axes: Sequence[FreeNumber]) -> int:
        return self.count or 0

    @abstractmethod
    def cube(self, width: int, first: int, count: int) -> Numbers:
        """Return the points in the unit cube, (count, width)."""

    @override
    def values(self, axes: Sequence[FreeNumber], first: int, count: int) -> Numbers:
        points = self.cube(len(axes), first, count)
        return np.stack([one.quantile(points[:, k]) for k, one in enumerate(axes)], axis=1)


DESIGNS: Registry[AbstractDesign] = Registry("sample", "martensite.design.sweep.sampling")


def parse_sampling(words: str, seed: int = 0) -> AbstractDesign:
    """Return the design of a text such as `grid` or `sobol:1024`.

    Raises:
        InputError: the name is unknown, or the number is malformed.
    """
    name, colon, count = words.partition(":")
    if colon and not count.strip().isdecimal():
        raise ParameterError(f"`{words}` must end with a number of runs, such as `{name}:1024`.")
    return DESIGNS[name.strip()](int(count) if colon else None, seed)


@DESIGNS.register("grid")
class Grid(AbstractDesign):
    """All combinations."""

    def __post_init__(self) -> None:
        """Raise `ParameterError` if a number of runs is given."""
        super().__post_init__()
        if self.count is not None:
            raise ParameterError(
                "The number of runs of a grid follows from its levels; write their "
                "levels behind each axis, such as `diameter=0.1..0.5 mm:9`."
            )

    def shape(self, axes: Sequence[FreeNumber]) -> tuple[int, ...]:
        """Return the numbers of levels of the axes."""
        return tuple(len(one.levels()) for one in axes)

    @override
    def size(self, axes: Sequence[FreeNumber]) -> int:
        runs = math.prod(self.shape(axes))
        if runs > MOST_RUNS:
            raise ParameterError(f"This grid has {runs:,} runs; at most {MOST_RUNS:,} are allowed.")
        return runs

    @override
    def values(self, axes: Sequence[FreeNumber], first: int, count: int) -> Numbers:
        places = np.unravel_index(np.arange(first, first + count), self.shape(axes))
        return np.stack([one.levels()[k] for one, k in zip(axes, places, strict=True)], axis=1)


TINY = 2.0**-54
MOST_STRATA = 20_000_000
"""Runs of the largest Latin hypercube."""


@DESIGNS.register("monte-carlo")
class MonteCarlo(AbstractSample):
    """Independent samples."""

    @override
    def cube(self, width: int, first: int, count: int) -> Numbers:
        stream = np.random.PCG64(self.seed)
        stream.advance(first * width)
        return np.maximum(np.random.Generator(stream).random((count, width)), TINY)


@DESIGNS.register("latin-hypercube")
class LatinHypercube(AbstractSample):
    """Points of a Latin hypercube, at random places in their strata."""

    def __post_init__(self) -> None:
        """Raise `ParameterError` for a missing or too large number of runs."""
        super().__post_init__()
        if (self.count or 0) > MOST_STRATA:
            raise ParameterError(
                f"A Latin hypercube has at most {MOST_STRATA:,} runs, not {self.count:,}; take `sobol`."
            )

    @override
    def cube(self, width: int, first: int, count: int) -> Numbers:
        stream = np.random.PCG64([self.seed, 1])
        stream.advance(first * width)
        inside = np.random.Generator(stream).random((count, width))
        strata = [_draw_strata(self.count or 0, self.seed, k)[first : first + count] for k in range(width)]
        return np.maximum((np.stack(strata, axis=1) + inside) / (self.count or 1), TINY)


@lru_cache(maxsize=64)
def _draw_strata(count: int, seed: int, axis: int) -> NDArray[np.int32]:
    """Return the strata of an axis in the order of the runs."""
    rng = np.random.Generator(np.random.PCG64([seed, 2, axis]))
    return rng.permutation(count).astype(np.int32)


@DESIGNS.register("sobol")
class Sobol(AbstractSample):
    """Points of a scrambled Sobol' sequence."""

    @override
    def cube(self, width: int, first: int, count: int) -> Numbers:
        with _one_at_a_time, warnings.catch_warnings():  # SciPy recommends a power of 2 in every call
            warnings.simplefilter("ignore", UserWarning)
            sequence = _begin_sequence(width, self.seed)
            if sequence.num_generated > first:
                sequence.reset()
            if sequence.num_generated < first:
                sequence.fast_forward(first - sequence.num_generated)
            points = sequence.random(count)
        return np.maximum(np.asarray(points, float), TINY)


_one_at_a_time = Lock()


@lru_cache(maxsize=8)
def _begin_sequence(width: int, seed: int) -> Any:
    """Return a cached sequence, since forwarding a new one takes time."""
    qmc: Any = import_module("scipy.stats.qmc")
    return qmc.Sobol(width, seed=seed)


@DESIGNS.register("saltelli")
class Saltelli(AbstractSample):
    """N base points, and N (d + 2) runs of d axes."""

    @override
    def size(self, axes: Sequence[FreeNumber]) -> int:
        runs = (self.count or 0) * count_block_runs(len(axes))
        if runs > MOST_RUNS:
            raise ParameterError(
                f"`saltelli:{self.count}` of {len(axes)} axes has {runs:,} runs; at most {MOST_RUNS:,} are allowed."
            )
        return runs

    @override
    def cube(self, width: int, first: int, count: int) -> Numbers:
        size = count_block_runs(width)
        rows = np.arange(first, first + count)
        begin, end = first // size, (first + count - 1) // size + 1
        points = Sobol(self.count, self.seed).cube(2 * width, begin, end - begin)
        a, b = points[rows // size - begin, :width], points[rows // size - begin, width:]
        member = (rows % size)[:, None]
        return np.where((member == np.arange(1, width + 1)) | (member == size - 1), b, a)


def count_block_runs(width: int) -> int:
    """Return the number of runs in a block."""
    return width + 2
