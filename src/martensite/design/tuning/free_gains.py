"""Free numbers of controllers, as texts of `martensite.search.free_numbers`: `Kp`, `Ki=0.1..10`.

A number that begins away from 0 keeps its sign and is searched on its logarithm. Bounds that are
not asked for are a hundredth of the least to the hundredfold of the largest start, or what is
declared of a number that begins at 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from martensite.base import units
from martensite.base.errors import ParameterError
from martensite.control.loop.bench import Bench
from martensite.search.free_numbers import (
    FreeNumber,
    SearchRange,
    Target,
    build_free,
    choose_bounds,
    is_bare,
    parse_free,
    read_free,
)

BOX_FACTOR = 100.0
"""Box around the starts, as a factor."""


def build_free_gains(bench: Bench, texts: Sequence[str], starts: Sequence[Mapping[str, float]]) -> list[FreeNumber]:
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
        path = find_gain(bench, parse_free(text)[0])
        target = Target.from_leaf(leaves[path])
        wanted = replace(_read_gain(text, target.unit), name=path)
        begun = [target.value, *(start[path] for start in starts if path in start)]
        low, high = choose_bounds(wanted, target, begun, BOX_FACTOR)
        scale = wanted.scale or ("log" if low * high > 0.0 else "linear")
        wanted = replace(wanted, low=low, high=high, scale=scale)
        found.append(build_free(wanted, [target], path))
    return found


def _read_gain(text: str, unit: str) -> SearchRange:
    """Bounds may have no unit: they are in SI then."""
    return read_free(text, unit, lambda x: float(x) if is_bare(x) else units.parse_quantity(x, unit))


def find_gain(bench: Bench, name: str) -> str:
    """Path in a bench of a parameter of its controllers."""
    return "controllers." + bench.controllers.resolve(name.removeprefix("controllers."))
