"""Repeated runs of one structure: what they share is computed once, and no run changes another.

Source of truth: the same runs with arrays, library and drives of their own, to the last bit.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from builders import problem_a

from martensite.kernels.compiler import find_compiler
from martensite.signals.base import AbstractWaveform
from martensite.signals.moments import Segment
from martensite.simulate import marching_native
from martensite.simulate.api import simulate
from martensite.simulate.compiled import compile_march
from martensite.simulate.result import Result

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler")
CALLS: list[str] = []


class Counted(AbstractWaveform):
    """Pulse of 2.5 V that notes when its segments are listed."""

    def value(self, time: float) -> float:
        """Return the voltage."""
        return 2.5 if 1.0 <= time < 6.0 else 0.0

    def segments(self, begin: float) -> Iterator[Segment]:
        """Yield the levels."""
        CALLS.append("segments")
        yield from (Segment(start, self.value(start)) for start in (0.0, 1.0, 6.0))


def run(system: Any, waveform: AbstractWaveform, tolerance: float = 1e-3, duration: float = 12.0) -> Result:
    """One run in C."""
    return simulate(system, waveform, duration, tolerance=tolerance, samples=121, runtime="c")


def alone(system: Any, waveform: AbstractWaveform, **more: float) -> Result:
    """One run in C with new arrays."""
    compile_march(system).idle.clear()
    return run(system, waveform, **more)


def require_same(one: Result, other: Result) -> None:
    """Raise `AssertionError` unless two results are equal in all bits."""
    assert one.accuracy == other.accuracy and one.restarts == other.restarts and str(one) == str(other)
    for name, column in one.columns.items():
        assert np.array_equal(column, other.columns[name]), name


def test_a_second_run_only_integrates(monkeypatch: pytest.MonkeyPatch) -> None:
    """It lists no segments, loads no library and makes no array that depends on the structure alone."""
    system, other, waveform = problem_a(), problem_a().with_values({"h0": 90.0}), Counted()
    whole, changed = alone(system, waveform), alone(other, waveform)
    CALLS.clear()
    for name in ("load_kernel", "kernel_of", "make_table"):
        monkeypatch.setattr(marching_native, name, lambda *_, name=name: CALLS.append(name))
    found = [run(one, waveform) for one in (system, other, system)]
    assert CALLS == []
    monkeypatch.undo()
    for one, meant in zip(found, (whole, changed, whole), strict=True):
        require_same(one, meant)


def test_runs_that_share_arrays_change_no_bit_of_each_other() -> None:
    """Other parameters, drives, tolerances, durations and steps between two equal runs."""
    system, waveform = problem_a(), Counted()
    cases = [
        (system, waveform, {}),
        (problem_a().with_values({"h0": 90.0, "length": 0.2}), waveform, {}),
        (system, waveform, {"tolerance": 1e-4}),
        (system, waveform, {"duration": 7.0}),
        (system, Counted(), {}),
    ]
    expected = [alone(*case[:2], **case[2]) for case in cases]
    for order in (cases, cases[::-1]):
        for case in order:
            require_same(run(*case[:2], **case[2]), expected[cases.index(case)])
    simulate(system, waveform, 12.0, step=0.05, samples=121, runtime="c")
    require_same(run(system, waveform), expected[0])


def test_a_result_keeps_its_arrays_and_its_steps() -> None:
    """Later runs neither change the columns of a result nor the accepted steps of its measures."""
    system, waveform = problem_a(), Counted()
    result, same = run(system, waveform), run(system, waveform)
    hottest, bound = same.measure("max(temperature)"), same.bound("max(temperature)")
    before = {name: column.copy() for name, column in result.columns.items()}
    run(system, waveform, tolerance=1e-4)
    assert all(np.array_equal(before[name], column) for name, column in result.columns.items())
    assert result.measure("max(temperature)") == hottest and result.bound("max(temperature)") == bound
    result.times[:] = 0.0
    assert run(system, waveform).times[-1] == 12.0


def test_runs_in_threads_have_arrays_of_their_own() -> None:
    """Eight runs in four threads equal those one after another."""
    systems = [problem_a().with_values({"h0": 60.0 + 5.0 * k}) for k in range(8)]
    waveform = Counted()
    expected = [alone(one, waveform) for one in systems]
    with ThreadPoolExecutor(4) as pool:
        for found, meant in zip(pool.map(lambda one: run(one, waveform), systems), expected, strict=True):
            require_same(found, meant)
