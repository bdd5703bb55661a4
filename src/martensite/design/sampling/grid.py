"""Every combination of the levels of all axes; the last axis varies fastest."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from martensite.base.errors import ParameterError
from martensite.design.sampling.base import DESIGNS, MOST_RUNS, AbstractDesign
from martensite.design.sweep.axes import Numbers, SweepAxis


@DESIGNS.register("grid")
class Grid(AbstractDesign):
    """All combinations."""

    def __post_init__(self) -> None:
        """Raise `ParameterError` if a number of runs is given: levels decide."""
        super().__post_init__()
        if self.count is not None:
            raise ParameterError(
                "A grid has as many runs as its axes have combinations of levels; write their "
                "levels behind each axis, such as `diameter=0.1..0.5 mm:9`."
            )

    def shape(self, axes: Sequence[SweepAxis]) -> tuple[int, ...]:
        """Levels of each axis."""
        return tuple(len(one.levels()) for one in axes)

    def size(self, axes: Sequence[SweepAxis]) -> int:
        """The product of all levels."""
        found = math.prod(self.shape(axes))
        if found > MOST_RUNS:
            raise ParameterError(f"This grid has {found:,} runs; at most {MOST_RUNS:,} are allowed.")
        return found

    def values(self, axes: Sequence[SweepAxis], first: int, count: int) -> Numbers:
        """Levels by their places on the grid."""
        places = np.unravel_index(np.arange(first, first + count), self.shape(axes))
        return np.stack([one.levels()[k] for one, k in zip(axes, places, strict=True)], axis=1)
