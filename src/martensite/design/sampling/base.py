"""Designs: which numbers every run of a sweep has.

Any stretch of runs can be asked for by itself, and is always the same: chunks do not depend on
which came before, or on who makes them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from martensite.base.errors import ParameterError
from martensite.base.registry import Registry
from martensite.design.sweep.axes import Numbers, SweepAxis

MOST_RUNS = 1_000_000_000


@dataclass(frozen=True)
class AbstractDesign(ABC):
    """Runs of a sweep."""

    registered_name: ClassVar[str] = ""
    count: int | None = None
    """How many samples are asked for; None on a grid."""
    seed: int = 0

    def __post_init__(self) -> None:
        """Raise `ParameterError` for a seed that cannot be."""
        if self.seed < 0:
            raise ParameterError(f"A seed is 0 or above, but is {self.seed}.")

    @abstractmethod
    def size(self, axes: Sequence[SweepAxis]) -> int:
        """Number of runs."""

    @abstractmethod
    def values(self, axes: Sequence[SweepAxis], first: int, count: int) -> Numbers:
        """Numbers of some runs from `first` on, (count, axes), in SI."""

    def shape(self, axes: Sequence[SweepAxis]) -> tuple[int, ...] | None:
        """Levels of each axis, if runs lie on a grid; the last one varies fastest."""
        return None


class AbstractSample(AbstractDesign):
    """A sample of the unit cube, put on the axes by their quantiles."""

    def __post_init__(self) -> None:
        """Raise `ParameterError` unless it is known how many."""
        super().__post_init__()
        if self.count is None or not 1 <= self.count <= MOST_RUNS:
            raise ParameterError(
                f"`{self.registered_name}` needs how many runs, such as `{self.registered_name}:1024`."
            )

    def size(self, axes: Sequence[SweepAxis]) -> int:
        """As many as are asked for."""
        return self.count or 0

    @abstractmethod
    def cube(self, width: int, first: int, count: int) -> Numbers:
        """Points in the unit cube, (count, width)."""

    def values(self, axes: Sequence[SweepAxis], first: int, count: int) -> Numbers:
        """The quantiles of points in the unit cube."""
        points = self.cube(len(axes), first, count)
        return np.stack([one.quantile(points[:, k]) for k, one in enumerate(axes)], axis=1)


DESIGNS: Registry[AbstractDesign] = Registry("sample", "martensite.design.sampling")


def parse_sampling(words: str, seed: int = 0) -> AbstractDesign:
    """The design that words such as `grid` or `sobol:1024` name.

    Raises:
        InputError: there is none of that name, or its number is none.
    """
    name, colon, count = words.partition(":")
    if colon and not count.strip().isdecimal():
        raise ParameterError(f"`{words}` must end with a number of runs, such as `{name}:1024`.")
    return DESIGNS[name.strip()](int(count) if colon else None, seed)
