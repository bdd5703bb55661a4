"""Free numbers of controllers, as texts of `martensite.search.free_numbers`: `Kp`, `Ki=0.1..10`.

A number that begins away from 0 keeps its sign and is searched on its logarithm. Bounds that are
not asked for are a hundredth of the least to the hundredfold of the largest start, or what is
declared of a number that begins at 0.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from martensite.base import units
from martensite.base.errors import ParameterError
from martensite.base.parameters import Leaf
from martensite.control.loop.bench import Bench
from martensite.search.free_numbers import (
    FreeNumber,
    SearchRange,
    Target,
    build_free,
    is_bare,
    parse_free,
    read_free,
)

BOX_FACTOR = 100.0
"""Box around the starts, as a factor."""


def build_free_gains(
    bench: Bench, texts: Sequence[str], starts: Sequence[Mapping[str, float]]
) -> list[FreeNumber]:
    """Free numbers of the controllers of a bench.

    Args:
        bench: the bench.
        texts: paths, or unique endings of paths among controllers, such as `drive.Kp` or `Kp`,
            with bounds if they are not to be chosen.
        starts: numbers by path where searches begin.

    Raises:
        ParameterError: an unknown name, a number without a sign or bounds, bounds that are none.
    """
    if not texts:
        raise ParameterError("Nothing is free: name parameters of controllers, such as Kp and Ki.")
    leaves = {leaf.path: leaf for leaf in bench.leaves()}
    found: list[FreeNumber] = []
    for text in texts:
        leaf = leaves[find_gain(bench, parse_free(text)[0])]
        wanted = _read_gain(text, leaf, [s[leaf.path] for s in starts if leaf.path in s])
        found.append(build_free(wanted, [Target.from_leaf(leaf)], leaf.path))
    return found


def find_gain(bench: Bench, name: str) -> str:
    """Path in a bench of a parameter of its controllers."""
    return "controllers." + bench.controllers.resolve(name.removeprefix("controllers."))


def _read_gain(text: str, leaf: Leaf, starts: list[float]) -> SearchRange:
    unit = leaf.declared.unit
    wanted = read_free(
        text, unit, lambda x: float(x) if is_bare(x) else units.parse_quantity(x, unit)
    )
    wanted = replace(wanted, name=leaf.path)
    if wanted.low is None or wanted.high is None:
        low, high = _choose_bounds(leaf, starts)
        wanted = replace(
            wanted,
            low=low if wanted.low is None else wanted.low,
            high=high if wanted.high is None else wanted.high,
        )
    one_sign = (wanted.low or 0.0) * (wanted.high or 0.0) > 0.0
    return replace(wanted, scale=wanted.scale or ("log" if one_sign else "linear"))


def _choose_bounds(leaf: Leaf, starts: list[float]) -> tuple[float, float]:
    """Bounds around the starts, of one sign; those declared of a number that begins at 0."""
    least, most = leaf.declared.bounds
    sizes = [value for value in [leaf.value, *starts] if value != 0.0]
    if not sizes:
        if math.isfinite(least) and math.isfinite(most):
            return least, most
        raise ParameterError(
            f"`{leaf.path}` is 0 and has no bounds: give it bounds or a start, or leave it out."
        )
    sign = math.copysign(1.0, sizes[-1])
    sizes = [sign * value for value in sizes if sign * value > 0.0]
    outer = [bound for bound in (sign * least, sign * most) if bound > 0.0]
    largest = min([BOX_FACTOR * max(sizes), *(b for b in outer if b >= max(sizes))])
    smallest = max([min(sizes) / BOX_FACTOR, *(b for b in outer if b < min(sizes))])
    low, high = sorted((sign * smallest, sign * largest))
    return low, high
