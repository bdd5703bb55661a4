"""Wires that are not the one in the model: what a maker's sheet leaves open, drawn of a fixed seed.

    ρ_A, ρ_M     (1 + 0.10 z₁)          A_s, A_f, M_s, M_f     + 5 K z₂
    h            2^z₃                   diameter               (1 + 0.03 z₄)
    ambient      + 10 K z₅              z evenly spread in [-1, 1]

z is a scrambled Sobol' sequence (Owen (1998)). Of several elements each has numbers of its own, and all have the same
surroundings. The numbers of a resistance, or of the temperatures, of one element move together: what is uncertain of a
wire is its alloy and its anneal, not one end of its strip.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from martensite.control.loop.bench import Bench
from martensite.search.starts import draw_points

Numbers = NDArray[np.float64]
COUNT, SEED = 64, 20_260
"""Wires of the benchmark, and their seed."""
RESISTIVITY, TEMPERATURES, FILM, DIAMETER, AMBIENT = 0.10, 5.0, 2.0, 0.03, 10.0
"""Half widths: a share, K, a factor, a share, K."""
POINTS = ("A_s", "A_f", "M_s", "M_f")


def draw_wires(bench: Bench, count: int = COUNT, seed: int = SEED) -> dict[str, Numbers]:
    """Parameters of a bench by path, shape (wires,) each.

    Args:
        bench: the nominal one.
        count: how many wires; a power of 2 spreads best. 1 is the nominal wire.
        seed: of the sequence.
    """
    values = {leaf.path: float(leaf.value) for leaf in bench.plant.leaves()}
    ports = [path.removesuffix("element.diameter") for path in values if path.endswith("element.diameter")]
    z = 2.0 * draw_points(4 * len(ports) + 1, count, seed).T - 1.0 if count > 1 else np.zeros((4 * len(ports) + 1, 1))
    found: dict[str, Numbers] = {}
    for k, port in enumerate(ports):
        found |= _draw_element(values, port, z[4 * k : 4 * k + 4])
    ambient = [path for path in values if path.endswith("environment.temperature")]
    found |= {path: values[path] + AMBIENT * z[-1] for path in ambient}
    return {f"plant.{path}": row for path, row in found.items()}


def _draw_element(values: dict[str, float], port: str, z: Numbers) -> dict[str, Numbers]:
    resistivity, shift, film, diameter = z
    found = {f"{port}element.diameter": values[f"{port}element.diameter"] * (1.0 + DIAMETER * diameter)}
    for name in ("rho_A", "rho_M"):
        path = f"{port}element.resistance.{name}"
        found[path] = values[path] * (1.0 + RESISTIVITY * resistivity)
    for name in POINTS:
        path = f"{port}element.law.{name}"
        found[path] = values[path] + TEMPERATURES * shift
    path = f"{port}environment.cooling.h"
    return found | {path: values[path] * FILM**film}
