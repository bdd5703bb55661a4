"""Sensitivity of a run to the last digit of its inputs.

Functions of libm round differently in a page, in C and in Python, and some runs magnify a last digit. The page reports
this measured limit of agreement.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from martensite.base.errors import MartensiteError
from martensite.scenario.scenario import Scenario
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.compiled import compile_march

TRIALS = 8
"""Runs with other last digits."""
MARGIN = 2.0
"""Safety factor on the largest difference."""
CLOSE = 1e-9
"""Relative tolerance of equal runs."""
VISIBLE = 1e-3
"""Relative difference that is visible in a curve."""
DIGIT = 2.0**-52
Columns = Mapping[str, Sequence[float] | Numbers]


def measure_rounding(scenario: Scenario) -> float:
    """Return the largest change of columns by the last digits, relative to their ranges; 0.0 up to `CLOSE`."""
    system = scenario.whole
    compiled, run = compile_march(system), scenario.run()
    least = dict(compiled.convergence_scales)
    values = dict(zip(compiled.paths, compiled.values(system), strict=True))
    values = {path: value for path, value in values.items() if _is_inexact(path, value, scenario)}
    entries: list[float] = []
    for seed in range(TRIALS):
        turns = np.random.default_rng(seed).integers(-1, 2, len(compiled.paths)).tolist()
        moved = {path: value * (1.0 + k * DIGIT) for (path, value), k in zip(values.items(), turns, strict=False)}
        other: Any = system.rebuilt(moved)
        twin = replace(scenario, system=other) if scenario.bench is None else replace(scenario, bench=other)
        with suppress(MartensiteError):  # a number that must be exact
            entries.append(compare_columns(run.columns, twin.run().columns, least))
    most = MARGIN * max(entries, default=0.0)
    return _round_up(most) if most > CLOSE else 0.0


def compare_columns(ours: Columns, others: Columns, least: Mapping[str, float]) -> float:
    """Return the largest difference of columns, relative to range or least scale, for constants to their size."""
    worst = 0.0
    for name, one in ours.items():
        other = others[name]
        size = float(np.max(np.abs(one)))
        span = max(float(np.ptp(one)), least.get(name, 0.0))
        apart = float(np.max(np.abs(np.subtract(one, other))))
        worst = max(worst, apart / (span if span > CLOSE * size else size)) if apart else worst
    return worst


def describe_rounding(share: float) -> str:
    """Return the sentence on rounding for the page; empty without an effect."""
    if not share:
        return ""
    words = f"{share:.0e}".replace("e-0", "e-") if share < VISIBLE else f"{100.0 * min(share, 1.0):.2g} %"
    return (
        f"This run magnifies the last digit of its numbers to as much as {words} of a range: "
        "`martensite run` may differ from this page by that, as it does from itself on another machine."
    )


def _is_inexact(path: str, value: float, scenario: Scenario) -> bool:
    """Return whether the last digit of a value is irrelevant.

    Integers can be limits of a range, and parameters around a plant count periods.
    """
    around = scenario.bench is not None and (not path.startswith("plant.") or ".source." in path)
    return not around and value % 1.0 != 0.0


def _round_up(value: float) -> float:
    """Return a value rounded up to one digit."""
    size = 10.0 ** math.floor(math.log10(value)) if math.isfinite(value) else 1.0
    return float(f"{min(math.ceil(value / size - CLOSE) * size, 1.0):.0e}")
