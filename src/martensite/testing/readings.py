"""Common inputs of suites for parts of a loop: usual readings, and a comparison with a traced part."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from martensite.base.parameters import Parametrised
from martensite.kernels import floats
from martensite.kernels.nested import flatten_numbers
from martensite.kernels.program import Program
from martensite.testing.conformance import require_condition
from martensite.testing.examples import build_plant

PERIOD = 0.02
"""Sampling period [s]."""
RANGES: dict[str, tuple[float, float]] = {
    "temperature": (295.0, 400.0),
    "hottest": (295.0, 400.0),
    "ambient": (270.0, 310.0),
    "position": (-0.01, 0.01),
    "angle": (-1.0, 1.0),
    "force": (0.0, 60.0),
    "stress": (0.0, 400e6),
    "strain": (-0.01, 0.06),
    "current": (0.0, 0.6),
    "voltage": (-1.0, 5.0),
    "power": (0.0, 3.0),
    "resistance": (3.0, 6.0),
    "martensite_fraction": (0.0, 1.0),
}
"""Usual ranges of true signals and readings [SI]."""
USUAL = (0.1, 1.0)
"""Usual range of any other signal."""


def observe_rest() -> dict[str, float]:
    """Return the outputs of the plant at rest [SI]."""
    plant = build_plant()
    outputs = plant.observe(floats, plant.init(floats, 0.0), 0.0)
    return dict(zip(plant.outputs(), outputs, strict=True))


def find_range(name: str) -> tuple[float, float]:
    """Return the usual range of a signal; prefixes such as `estimated.` and ages are allowed."""
    if name.endswith(".age"):
        return 0.0, 1.0
    return RANGES.get(name.rpartition(".")[2], USUAL)


def draw_readings(names: Iterable[str], rng: np.random.Generator) -> dict[str, float]:
    """Return random readings and ages."""
    both = [entry for name in names for entry in (name, f"{name}.age")]
    return {name: float(rng.uniform(*find_range(name))) for name in both}


def require_same_traced(
    part: Parametrised, kernel: Callable[..., Any], ranges: Mapping[str, tuple[float, float]], count: int = 12
) -> None:
    """Raise `ConformanceError` unless a traced kernel gives the same values as on plain floats.

    Args:
        part: the part.
        kernel: function (part, namespace, *inputs) of numbers in nested tuples.
        ranges: names and ranges of the random inputs.
        count: number of random inputs.
    """
    program = Program()
    twin = part.rebuilt({leaf.path: program.parameter(leaf.path) for leaf in part.leaves()})

    def flat(xp: Any, *inputs: Any) -> list[Any]:
        return flatten_numbers((kernel(twin, xp, *inputs),))

    program.add("kernel", list(ranges), flat)
    traced = program.bind_floats(*(leaf.value for leaf in part.leaves()))["kernel"]
    rng = np.random.default_rng(len(ranges))
    for _ in range(count):
        row = [float(rng.uniform(*both)) for both in ranges.values()]
        expected = flatten_numbers((kernel(part, floats, *row),))
        equal = np.allclose(traced(*row), expected, rtol=1e-9, atol=1e-12)
        require_condition(equal, "Traced, as in a run, it says another number than on plain floats.")
