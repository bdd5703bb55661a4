"""Sweeps of plain functions, without a store: what was found is known in closed form."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from martensite.design.sweep.sampling.samples import parse_sampling
from martensite.design.sweep.table import SweepColumn, SweepTable
from martensite.search.free_numbers import FreeNumber, Target

Function = Callable[[np.ndarray], np.ndarray]
ISHIGAMI_A, ISHIGAMI_B = 7.0, 0.1
ANGLES = [
    FreeNumber(one.name, one.path, one.unit, 0.0, -np.pi, np.pi, targets=(one,))
    for one in (Target(f"part.x{k}", f"x{k}", "1", 0.0) for k in (1, 2, 3))
]


def ishigami(x: np.ndarray) -> np.ndarray:
    """Ishigami and Homma (1990): sin x1 + a sin² x2 + b x3⁴ sin x1."""
    a, b = ISHIGAMI_A, ISHIGAMI_B
    return np.sin(x[:, 0]) * (1.0 + b * x[:, 2] ** 4) + a * np.sin(x[:, 1]) ** 2


def ishigami_indices() -> tuple[np.ndarray, np.ndarray]:
    """First and total order for angles that are evenly spread from -π to π."""
    a, b = ISHIGAMI_A, ISHIGAMI_B
    one = 0.5 * (1.0 + b * np.pi**4 / 5.0) ** 2
    two, both = a**2 / 8.0, b**2 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    variance = one + two + both
    return np.array([one, two, 0.0]) / variance, np.array([one + both, two, both]) / variance


def table(sample: str, axes: Sequence[FreeNumber] = ANGLES, seed: int = 1, **measures: Function) -> SweepTable:
    """A sweep of functions of the varied numbers, all runs made."""
    found = parse_sampling(sample, seed)
    x = found.values(axes, 0, found.size(axes))
    columns = zip(axes, x.T, strict=True)
    return SweepTable(
        "Functions",
        sample,
        {one.target.name: SweepColumn(one.target.name, one.target.unit, v, one.logarithmic) for one, v in columns},
        {name: SweepColumn(name, "m", function(x)) for name, function in measures.items()},
        np.zeros(len(x), np.int8),
        tuple(one.levels() for one in axes) if sample == "grid" else None,
    )


def with_status(found: SweepTable, **rows: Sequence[int]) -> SweepTable:
    """With other statuses, such as `s2=[5]` for run 5; failed runs have no numbers."""
    status = found.status.copy()
    for name, places in rows.items():
        status[list(places)] = -1 if name == "missing" else int(name[1:])
    gone = (status < 0) | (status > 1)
    measures = {name: replace(one, values=np.where(gone, np.nan, one.values)) for name, one in found.measures.items()}
    return replace(found, status=status, measures=measures)


def with_value(found: SweepTable, name: str, row: int, value: float) -> SweepTable:
    """With another number of a measure in one run."""
    values = found.measures[name].values.copy()
    values[row] = value
    changed = replace(found.measures[name], values=values)
    return replace(found, measures={**found.measures, name: changed})
