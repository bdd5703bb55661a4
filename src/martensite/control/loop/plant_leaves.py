"""Numbers of the plant on a bench, and how far they may spread."""

from martensite.base.parameters import Leaf
from martensite.control.loop.bench import Bench

PLANT = "plant."
"""Prefix of the paths of the plant's parameters on a bench."""


def find_plant_leaf(bench: Bench, name: str) -> Leaf:
    """Find the parameter of the plant of a path, or a unique ending; raise `ParameterError` if none matches."""
    path = bench.plant.resolve(name.removeprefix(PLANT))
    return next(leaf for leaf in bench.plant.leaves() if leaf.path == path)


def parse_half_width(leaf: Leaf, spread: float) -> float:
    """Return the half the width of a spread, in SI: a share of the number, or kelvin for a temperature."""
    return spread if leaf.declared.unit == "K" else spread * abs(leaf.value)


def require_allowed(leaf: Leaf, *values: float) -> None:
    """Raise `ParameterError` unless a number may have all these values."""
    for value in values:
        leaf.declared.convert(leaf.owner, leaf.path, value)
