"""Parameters of the plant on a bench, and their spread."""

from martensite.base.parameters import Leaf
from martensite.control.loop.bench import Bench

PLANT = "plant."
"""Prefix of the parameters of the plant on a bench."""


def find_plant_leaf(bench: Bench, name: str) -> Leaf:
    """Return the parameter of the plant with a path, or a unique ending of it."""
    path = bench.plant.resolve(name.removeprefix(PLANT))
    return next(leaf for leaf in bench.plant.leaves() if leaf.path == path)


def parse_half_width(leaf: Leaf, spread: float) -> float:
    """Return half the width of a spread, in SI: a fraction of the value, or kelvin for a temperature."""
    return spread if leaf.declared.unit == "K" else spread * abs(leaf.value)


def require_allowed(leaf: Leaf, *values: float) -> None:
    """Raise `ParameterError` unless a parameter may have all these values."""
    for value in values:
        leaf.declared.convert(leaf.owner, leaf.path, value)
