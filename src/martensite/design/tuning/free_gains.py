"""Free numbers of controllers: where they are, between which bounds, on which scale.

    p = sign e^z          for a number that begins away from 0, which keeps its sign
    p = z                 for one that may be 0 and has declared bounds

Bounds are those asked for, else a hundredth of the least to the hundredfold of the largest start.
A start beyond them, or at 0, begins at the nearest bound.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import ParameterError
from martensite.base.parameters import Leaf
from martensite.control.loop.bench import Bench

WIDE = 100.0
"""Box around the starts, as a factor."""
NEAR = 1e-3
"""Part of the box from a bound that counts as being there."""
Bounds = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class FreeGain:
    """A number to be found."""

    path: str
    sign: float
    """-1 or 1 on a logarithmic scale, 0 on a linear one."""
    low: float
    """Bound of z."""
    high: float

    def value(self, z: Any) -> Any:
        """The number at z."""
        return self.sign * np.exp(z) if self.sign else z

    def slope(self, z: float) -> float:
        """d(number)/dz."""
        return self.value(z) if self.sign else 1.0

    def place(self, value: float) -> float:
        """z of a number, within the bounds."""
        if not self.sign:
            return min(max(value, self.low), self.high)
        size = self.sign * value
        return min(max(math.log(size), self.low), self.high) if size > 0.0 else self.low

    def caught(self, z: float) -> float | None:
        """The number at a bound, if z is there."""
        hair = NEAR * (self.high - self.low)
        for bound in (self.low, self.high):
            if abs(z - bound) <= hair:
                return float(self.value(bound))
        return None


def free_gains(
    bench: Bench, names: Sequence[str], starts: Sequence[Mapping[str, float]],
    bounds: Bounds | None = None,
) -> list[FreeGain]:  # fmt: skip
    """Free numbers of the controllers of a bench.

    Args:
        bench: the bench.
        names: paths, or unique endings of paths among controllers, such as `drive.Kp` or `Kp`.
        starts: numbers by path where searches begin.
        bounds: least and largest number by the name that was given.

    Raises:
        ParameterError: an unknown name, a number without a sign or bounds, bounds that are none.
    """
    asked = dict(bounds or {})
    unknown = next((name for name in asked if name not in names), None)
    if unknown is not None:
        raise ParameterError(f"There are bounds for `{unknown}`, which is not free.")
    if not names:
        raise ParameterError("Nothing is free: name parameters of controllers, such as Kp and Ki.")
    leaves = {leaf.path: leaf for leaf in bench.leaves()}
    paths = [path_of(bench, name) for name in names]
    return [
        _free(leaves[path], [s[path] for s in starts if path in s], asked.get(name))
        for path, name in zip(paths, names, strict=True)
    ]


def path_of(bench: Bench, name: str) -> str:
    """Path in a bench of a parameter of its controllers."""
    return "controllers." + bench.controllers.resolve(name.removeprefix("controllers."))


def _free(leaf: Leaf, starts: list[float], asked: tuple[float, float] | None) -> FreeGain:
    least, most = leaf.declared.bounds
    sizes = [value for value in [leaf.value, *starts] if value != 0.0]
    sign = math.copysign(1.0, sizes[-1] if sizes else 1.0)
    if asked is not None:
        low, high = asked
        if not (least <= low < high <= most):
            raise ParameterError(
                f"Bounds of `{leaf.path}` must rise and be {leaf.declared.allowed()}, but are "
                f"{low:g} and {high:g}."
            )
        if low <= 0.0 <= high:
            return FreeGain(leaf.path, 0.0, low, high)
        ends = sorted((abs(low), abs(high)))
        return FreeGain(leaf.path, math.copysign(1.0, low), math.log(ends[0]), math.log(ends[1]))
    sizes = [sign * value for value in sizes if sign * value > 0.0]
    if not sizes:
        if math.isfinite(least) and math.isfinite(most):
            return FreeGain(leaf.path, 0.0, least, most)
        raise ParameterError(
            f"`{leaf.path}` is 0 and has no bounds: give it bounds or a start, or leave it out."
        )
    outer = [bound for bound in (sign * least, sign * most) if bound > 0.0]
    largest = min([WIDE * max(sizes), *(b for b in outer if b >= max(sizes))])
    smallest = max([min(sizes) / WIDE, *(b for b in outer if b < min(sizes))])
    return FreeGain(leaf.path, sign, math.log(smallest), math.log(largest))


def values_at(free: Sequence[FreeGain], z: NDArray[np.float64]) -> dict[str, Any]:
    """Numbers by path at places z, shape (..., free)."""
    return {one.path: one.value(z[..., k]) for k, one in enumerate(free)}
