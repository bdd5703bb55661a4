"""Sensitivity of a run to the last digit of its numbers.

A page rounds functions of libm differently from C and Python, usually without effect. But step lengths depend on small
differences, and a controller may be close to a threshold. Some runs therefore magnify a last digit, which limits the
agreement of two implementations. The page reports this measured limit.
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
from martensite.simulate.result import Result

TRIALS = 8
"""Runs under other last digits."""
MARGIN = 2.0
"""Safety factor on the largest difference of a few runs."""
CLOSE = 1e-9
"""Share of a range up to which two runs are equal."""
VISIBLE = 1e-3
"""Share of a range that is seen in a curve."""
DIGIT = 2.0**-52
Columns = Mapping[str, Sequence[float] | Numbers]


def measure_rounding(scenario: Scenario, *others: Result) -> float:
    """Return the most by which columns move with the last digits, as a share of their ranges; 0.0 up to `CLOSE`.

    Args:
        scenario: the run.
        others: the same run on other runtimes, whose differences count, too.
    """
    system = scenario.whole
    compiled, run = compile_march(system), scenario.run()
    least = dict(compiled.convergence_scales)
    values = dict(zip(compiled.paths, compiled.values(system), strict=True))
    values = {path: value for path, value in values.items() if _is_inexact(path, value, scenario)}
    found = [compare_columns(run.columns, one.columns, least) for one in others]
    for seed in range(TRIALS):
        turns = np.random.default_rng(seed).integers(-1, 2, len(compiled.paths)).tolist()
        moved = {path: value * (1.0 + k * DIGIT) for (path, value), k in zip(values.items(), turns, strict=False)}
        other: Any = system.rebuilt(moved)
        twin = replace(scenario, system=other) if scenario.bench is None else replace(scenario, bench=other)
        with suppress(MartensiteError):  # a number that must be exact
            found.append(compare_columns(run.columns, twin.run().columns, least))
    most = MARGIN * max(found, default=0.0)
    return _round_up(most) if most > CLOSE else 0.0


def compare_columns(ours: Columns, others: Columns, least: Mapping[str, float]) -> float:
    """Return the largest difference: of the range of a column or the least that counts, of constants of their size."""
    worst = 0.0
    for name, one in ours.items():
        other = others[name]
        size = float(np.max(np.abs(one)))
        span = max(float(np.ptp(one)), least.get(name, 0.0))
        apart = float(np.max(np.abs(np.subtract(one, other))))
        worst = max(worst, apart / (span if span > CLOSE * size else size)) if apart else worst
    return worst


def describe_rounding(share: float) -> str:
    """Return the sentence about rounding on the page; empty without an effect."""
    if not share:
        return ""
    words = f"{share:.0e}".replace("e-0", "e-") if share < VISIBLE else f"{100.0 * min(share, 1.0):.2g} %"
    return (
        f"This run magnifies the last digit of its numbers to as much as {words} of a range: "
        "`martensite run` may differ from this page by that, as it does from itself on another machine."
    )


def _is_inexact(path: str, value: float, scenario: Scenario) -> bool:
    """Return whether the last digit of a value is irrelevant.

    Whole numbers may be ends of a range, and numbers around a plant count periods.
    """
    around = scenario.bench is not None and (not path.startswith("plant.") or ".source." in path)
    return not around and value % 1.0 != 0.0


def _round_up(value: float) -> float:
    """To one digit."""
    size = 10.0 ** math.floor(math.log10(value)) if math.isfinite(value) else 1.0
    return float(f"{min(math.ceil(value / size - CLOSE) * size, 1.0):.0e}")
