"""Two runs whose parameters differ by rounding differ by no more than their stated errors, for every law with memory.

Source of truth: a stated error bounds the difference to the exact solution, so the errors of two such runs bound their
difference. Each test narrows an interval of a drive level to the largest change of the result: a jump, if there is one.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from builders import LAW_A, problem_a, wire_a

from martensite.kernels.compiler import find_compiler
from martensite.physics.laws.base import LAWS
from martensite.signals.table import Table
from martensite.simulate.api import simulate
from martensite.simulate.batch import simulate_batch
from martensite.simulate.result import Result
from martensite.testing.examples import build_example

END, SCANNED, NARROWED = 30.0, 25, 24
JUDGED = ("temperature", "martensite_fraction", "stress", "position")
FORGETFUL: dict[str, dict[str, Any]] = {
    "liang-rogers": {},
    "liang-rogers, smooth and curved": {"hardening": "smooth", "surfaces": "curved"},
    "tanaka": {"E_M": 75e9},
    "brinson": {},
    "r-phase": {"eps_R": 0.005},
    "brinson, compression": {"compression": "symmetric"},
}
"""Laws that forget a branch on a surface under the rule `resume`."""
CONTINUOUS: dict[str, dict[str, Any]] = {
    "liang-rogers": {"history": "return-point"},
    "liang-rogers, again": {"history": "restart"},
    "tanaka": {"E_M": 75e9, "history": "return-point"},
    "brinson": {"history": "return-point"},
    "lagoudas": {},
}
"""Laws that forget no branch on a surface."""
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


def make_law(name: str, changes: dict[str, Any]) -> Any:
    cls = LAWS[name.partition(",")[0]]
    return build_example(cls, **{key: value for key, value in LAW_A.items() if key in cls.declarations} | changes)


def reheat(level: float) -> Table:
    """Heating, cooling into the forward transformation, a second pulse, and cooling again [V]."""
    return Table(
        times=(0.0, 1.0, 8.0, 8.2, 10.5, 10.8, 14.0, 14.1, 15.0, 16.0, END),
        values=(0.0, 2.8, 2.8, 0.4, 0.4, level, level, 0.8, 0.8, 1.1, 1.1),
    )


def pause(level: float) -> Table:
    """Heating into the reverse transformation, a pause with less heat, and heating again [V]."""
    return Table(times=(0.0, 1.0, 5.0, 5.1, 11.0, 11.1, END), values=(0.0, 2.35, 2.35, level, level, 2.5, 2.5))


def run_law(law: Any, drive: Callable[[float], Table], level: float, **changes: Any) -> Result:
    how: dict[str, Any] = {"tolerance": 1e-4, "runtime": "c", "samples": 301} | changes
    return simulate(problem_a(element=wire_a(law)), drive(level), END, **how)


def find_distance(one: Result, other: Result) -> float:
    """Return the largest difference of two results, as a fraction of ranges."""
    pairs = [[np.asarray(r.columns[name]) for r in (one, other)] for name in JUDGED]
    return max(float(np.abs(a - b).max() / np.ptp(a)) for a, b in pairs)


def narrow(law: Any, drive: Callable[[float], Table], low: float, high: float) -> tuple[Result, Result]:
    """Return the runs at both ends of a tiny interval at the sharpest change of the result."""
    levels = np.linspace(low, high, SCANNED).tolist()
    found = [run_law(law, drive, level) for level in levels]
    apart = np.array([find_distance(*pair) for pair in pairwise(found)])
    at = 1 + int((apart[1:-1] - np.maximum(apart[:-2], apart[2:])).argmax())
    ends, pair = (levels[at], levels[at + 1]), (found[at], found[at + 1])
    for _ in range(NARROWED):
        middle = 0.5 * sum(ends)
        made = run_law(law, drive, middle)
        if find_distance(pair[0], made) > find_distance(made, pair[1]):
            ends, pair = (ends[0], middle), (pair[0], made)
        else:
            ends, pair = (middle, ends[1]), (made, pair[1])
    return pair


def list_cases(laws: dict[str, dict[str, Any]]) -> list[Any]:
    """Return every law with one drive in turn and its levels around a touch of the surface [V]."""
    drives = (reheat, 2.0, 2.3), (pause, 1.45, 1.75)
    cases = [(name, drives[k % 2]) for k, name in enumerate(laws)]
    return [pytest.param(name, *drive, id=f"{name} {drive[0].__name__}") for name, drive in cases]


def bound_distance(one: Result, other: Result) -> float:
    assert one.accuracy is not None
    assert other.accuracy is not None
    return one.accuracy + other.accuracy


@needs_compiler
@pytest.mark.parametrize(("name", "drive", "low", "high"), list_cases(FORGETFUL))
def test_a_touch_of_a_surface_is_reported(name: str, drive: Callable[[float], Table], low: float, high: float) -> None:
    one, other = narrow(make_law(name, FORGETFUL[name]), drive, low, high)
    distance, direct = find_distance(one, other), "forward" if drive is reheat else "reverse"
    assert distance > 1e-2, "the drive finds no jump"
    assert all(f"the law forgets the interrupted {direct} tr" in " ".join(r.warnings) for r in (one, other))
    assert distance <= bound_distance(one, other)


@needs_compiler
@pytest.mark.parametrize(("name", "drive", "low", "high"), list_cases(CONTINUOUS))
def test_other_laws_have_no_jump(name: str, drive: Callable[[float], Table], low: float, high: float) -> None:
    one, other = narrow(make_law(name, CONTINUOUS[name]), drive, low, high)
    assert find_distance(one, other) <= bound_distance(one, other)
    assert not one.warnings


@needs_compiler
def test_complete_twins_forget_no_return_point() -> None:
    """Twins that complete martensite between two levels of a pause change nothing."""
    one, other = narrow(make_law("brinson", CONTINUOUS["brinson"]), pause, 0.5, 1.3)
    assert find_distance(one, other) <= bound_distance(one, other)


@needs_compiler
def test_all_runtimes_report_the_same_decision() -> None:
    law = make_law("liang-rogers", {})
    one, _ = narrow(law, reheat, 2.0, 2.3)
    level = one.waveform.values[5]
    on_floats = run_law(law, reheat, level, runtime="floats")
    assert "the law forgets the interrupted forward transformation" in on_floats.warnings[0]
    system = problem_a(element=wire_a(law))
    ends = [law.A_s, law.A_s + 1.0] * 8
    batch = simulate_batch(system, reheat(level), END, {"element.law.A_s": ends}, runtime="c", samples=301)
    bounds = batch.variants.accuracy if batch.variants else None
    assert bounds is not None
    for bound in (on_floats.accuracy, bounds[0]):
        assert bound == pytest.approx(one.accuracy, rel=0.02)
    assert bounds[1] < 1e-4
    assert "8 of 16 variants missed the tolerance" in batch.warnings[0]
