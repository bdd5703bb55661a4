"""Simulation to a tolerance, in Python floats or compiled C.

A run is repeated with local tolerances that are `FINER` times smaller. The difference of two passes times
`ERROR_SAFETY` bounds the error of the second pass. Passes are repeated until this bound is below the tolerance. For
random wires, the error is a quarter of the difference in the median and 1.4 times in one of a hundred. Two passes may
have a common error, for example at a kink. A tenth of the tolerance is therefore added to a bound, up to half of the
tolerance. Where many points share a stress, the reported accuracy is the tolerance.

The bound also includes the ripple that drive means neglect. If a step at minimum length exceeds its tolerance, two
passes hardly differ. The sum of these errors times `ERROR_SAFETY` is then added. All passes but the first split the
last step before a drive edge, so that two passes do not take identical steps.

A law may forget a branch on a surface. If the path turns within its error of such a surface, the bound is at least the
effect of the other decision (`martensite.simulate.forks`).
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import BudgetError, CompileError
from martensite.base.files import tell_once
from martensite.base.remember_results import remember
from martensite.simulate.adaptive import PER_STRESS, AdaptiveMarch
from martensite.simulate.compiled import CompiledMarch
from martensite.simulate.forks import Decision, LawFork
from martensite.simulate.march import FixedMarch
from martensite.simulate.marching import MarchPlan, MarchResult
from martensite.simulate.recorded_track import Observe, observe_on_floats
from martensite.simulate.restarts import SampleTimes
from martensite.simulate.track import Numbers

Tell = Callable[[str, float], None]
"""Callback with the current activity and the completed fraction."""
PATIENCE = 0.5
"""CPU time [s] on floats before an optimising compiler is started."""
LOADING_PATIENCE = 0.1
"""CPU time [s] of a run that justifies loading a compiled library, or the quick compiler."""
LARGE = 2500
"""Number of operations above which the quick compiler is faster than Python's."""
NATIVE = "martensite.simulate.marching_native"
"""Module that short runs do not import."""
RARELY = 8
"""Steps on floats between two clock readings."""
OFTEN = 0.1
"""Time [s] between two calls of the progress callback."""
LOCAL = {2: 0.24, 4: 0.96, 5: 0.15}
"""Accepted step error of the first run, as a fraction of the tolerance, by order.

A step of order four is estimated with order three.
"""
ERROR_SAFETY = 1.25
"""Ratio of the error bound to the difference of two runs."""
FLOOR = 0.5
"""Bounds below this fraction of the tolerance are raised, since two passes may have a common error.

The fraction is twice as large where many points share a stress.
"""
COMMON = 0.1
"""Common error of two passes, as a fraction of the tolerance; below `FLOOR`."""
FINER = 8.0
"""Ratio of local tolerances of consecutive passes."""
MOST_PASSES = 5
"""Maximum number of runs after the first."""
FEW = 201
"""Approximate number of compared samples."""
LEAST_ACCURACY = 1e-12
"""Smallest accuracy that is reported."""

March = Callable[[MarchPlan], MarchResult]
_SPENT: WeakKeyDictionary[CompiledMarch, float] = WeakKeyDictionary()
"""CPU time [s] on floats in this process, by structure; many short runs also justify a compiler."""


@dataclass
class RunEngine:
    """Runner of passes on the requested runtime."""

    compiled: CompiledMarch
    values: Sequence[float]
    runtime: str
    """`floats`, `c` or `auto`."""
    tell: Tell | None = None
    budget: float | None = None
    """CPU time [s] for all passes together."""
    last_runtime: str = "floats"
    """Runtime of the last pass."""
    begin: float = field(default_factory=time.process_time)

    def __call__(self, plan: MarchPlan) -> MarchResult:
        """Run a plan; raise `BudgetError` if the budget is spent."""
        ways = {"auto": self._quickest, "c": self._on_c, "floats": self._on_floats}
        run = ways[self.runtime](plan)
        run.runtime = self.last_runtime
        return run

    def _quickest(self, plan: MarchPlan) -> MarchResult:
        """Run on floats if the run is short or no compiler is available, else in C."""
        from martensite.kernels.compiler import find_compiler

        if find_compiler() is None:
            return self._on_floats(plan)
        if self.last_runtime == "C" or (NATIVE in sys.modules and self._readiness(plan) == "loaded"):
            return self._on_c(plan)
        if len(self.compiled.program.graph.depends) > LARGE and _compiles_at_once():
            return self._on_c_if_possible(plan)
        begin, spent = time.process_time(), _SPENT.get(self.compiled, 0.0)
        if spent <= PATIENCE:
            try:
                return self._on_floats(plan, hasty=True)
            except TimeoutError:
                pass
            finally:
                _SPENT[self.compiled] = spent + time.process_time() - begin
        return self._on_c_if_possible(plan)

    def _on_c_if_possible(self, plan: MarchPlan) -> MarchResult:
        """Run in C, or on floats if the compiler fails."""
        try:
            return self._on_c(plan)
        except CompileError as error:
            tell_once(f"Warning: the run goes on on floats. {error}")
            return self._on_floats(plan)

    def _readiness(self, plan: MarchPlan) -> str:
        """Return the state of preparation of the C runtime."""
        from martensite.simulate.march_kernel import kernel_of, tell_readiness

        return tell_readiness(kernel_of(plan, range(len(self.compiled.outputs))))

    def _on_floats(self, plan: MarchPlan, hasty: bool = False) -> MarchResult:
        """Run on floats; raise `TimeoutError` if `hasty` and C would be faster."""
        self.last_runtime = "floats"
        functions = self.compiled.program.bind_floats(*self.values)
        march = FixedMarch if plan.step else AdaptiveMarch
        begin, watch = time.process_time(), self._watch("simulating")
        patience, looks = LOADING_PATIENCE if hasty else math.inf, 0

        def look(share: float) -> None:
            nonlocal patience, looks
            looks += 1
            if looks % RARELY:
                return
            if time.process_time() - begin > patience:
                if patience == PATIENCE or _compiles_at_once() or self._readiness(plan) != "new":
                    raise TimeoutError
                patience = PATIENCE
            watch(share)

        return march(plan, functions).run(look)

    def _on_c(self, plan: MarchPlan) -> MarchResult:
        """Run in C and compile if necessary."""
        from martensite.simulate.marching_native import NativeMarch, Runs

        if self.tell is not None and self._readiness(plan) == "new":
            self.tell("compiling", 0.0)
        self.last_runtime = "C"
        runs, idle = Runs(plan, self.values, 1, tuple(range(len(self.compiled.outputs))), 1), self.compiled.idle
        try:
            marching = idle.pop()
        except IndexError:
            marching = NativeMarch(runs)
        else:
            marching.set_runs(runs)
        run = marching.go(self._watch("simulating")).take_run(0, plan.times, plan.recorded)
        idle.append(marching)
        return run

    def observe(self, plan: MarchPlan, outputs: Sequence[int], used: str) -> Observe:
        """Return the function that computes outputs of recorded states on the runtime `used`."""
        if used == "C":
            from martensite.simulate.marching_native import Runs, observe_in_c

            every = tuple(range(len(self.compiled.outputs)))
            observe = observe_in_c(Runs(plan, self.values, 1, every, 1))
            return lambda states, signals, run: observe(states, signals, run)[:, list(outputs)]
        return observe_on_floats(self.compiled.program.bind_floats(*self.values)["observe"], outputs)

    def _watch(self, doing: str) -> Callable[[float], None]:
        """Return a function that checks the budget and reports progress at intervals."""
        last = 0.0

        def watch(share: float) -> None:
            nonlocal last
            spent = require_budget(self.budget, self.begin, share)
            if self.tell is not None and spent - last > OFTEN:
                last = spent
                self.tell(doing, share)

        return watch


def _compiles_at_once() -> bool:
    """Return whether a C library takes no noticeable time to compile."""
    from martensite.kernels.quick_compiler import compiles_at_once

    return compiles_at_once()


def require_budget(budget: float | None, begin: float, share: float) -> float:
    """Return the CPU time [s] since `begin`; raise `BudgetError` if it exceeds the budget [s].

    Args:
        budget: CPU time that may be spent [s]; None for any.
        begin: `time.process_time` at the start of the run.
        share: fraction of the run that is done.
    """
    spent = time.process_time() - begin
    if budget is not None and spent > budget:
        raise BudgetError(
            f"The run was stopped, for its budget of {budget:.4g} s of CPU time was spent at {100.0 * share:.2g} % of "
            "it. Allow more, a larger tolerance, or a shorter run."
        )
    return spent


def march_to(march: March, plan: MarchPlan, tolerance: float) -> tuple[MarchResult, float]:
    """Return the last run to a tolerance and its error bounds as fractions of the ranges of judged outputs."""
    compiled, compared = plan.compiled, choose_samples(len(plan.times), plan.skipped)
    local, bound = LOCAL[plan.order] * tolerance, math.inf
    run = march(plan._replace(times=choose_times(plan.times, plan.skipped), recorded=False, tolerance=local))
    rows = run.rows
    for turn in range(MOST_PASSES):
        local /= FINER
        ranges = run.ranges if turn or not shares_stress(compiled) else ()
        run = march(plan._replace(tolerance=local, ranges=ranges, parted=True))
        before, rows = rows, choose_rows(run.rows, compared)
        run.gaps = find_gaps(compiled, before, rows)[1 if run.gap else 0 :]
        run.largest = run.find_largest_gap(run.gap)
        bound = bound_error(compiled, run)
        if bound <= tolerance:
            break
    error = max(bound, find_floor(compiled) * tolerance)
    run.undecided, change = find_doubt(compiled, run.decision, error, run.ranges)
    return run, max(float(add_common(compiled, bound, tolerance)), change)


def find_doubt(
    compiled: CompiledMarch, decision: Decision, accuracy: float, ranges: Sequence[float]
) -> tuple[float, float]:
    """Return the error [K] and effect of a decision that the error of a run may change; 0 for others.

    The effect is the change of the martensite fraction as a fraction of its range.

    Args:
        compiled: system of the run.
        decision: closest decision of the run.
        accuracy: error bound of the run without this decision.
        ranges: ranges of judged outputs.
    """
    if decision.place < 0:
        return 0.0, 0.0
    fork = compiled.forks[decision.place]
    scales = [max(*pair) for pair in zip(ranges, (least for _, least in compiled.convergence_scales), strict=True)]
    error, effect = bound_temperature(fork, accuracy, scales), fork.weight * decision.change / scales[fork.fraction]
    return (error, effect) if abs(decision.margin) <= error and effect > accuracy else (0.0, 0.0)


def bound_temperature(fork: LawFork, accuracy: Any, scales: Sequence[Any]) -> Any:
    """Return the error [K] of the temperature at a fork, with the effect of stress on the transformation.

    Args:
        fork: branch that a law may forget.
        accuracy: error bound of a run, or of several, (runs,).
        scales: ranges of the judged outputs, each a number or (runs,).
    """
    return accuracy * (scales[fork.temperature] + PER_STRESS * scales[fork.stress])


def add_common(compiled: CompiledMarch, bound: Any, tolerance: float) -> Any:
    """Return the reported accuracy for an error bound from two passes, or for an array of bounds.

    Args:
        compiled: system of the runs.
        bound: error bound, as a fraction of ranges.
        tolerance: tolerance of the runs.
    """
    floor = find_floor(compiled) * tolerance
    return np.maximum(bound, floor if shares_stress(compiled) else np.minimum(bound + COMMON * tolerance, floor))


def find_floor(compiled: CompiledMarch) -> float:
    """Return the fraction of the tolerance below which a bound is raised; see `FLOOR`."""
    return 2.0 * FLOOR if shares_stress(compiled) else FLOOR


@remember
def shares_stress(compiled: CompiledMarch) -> bool:
    """Return whether fibres or cells of an element load each other.

    Stress then amplifies temperature errors. Both runs must therefore be judged by the known ranges from their start.
    """
    return any(point.weight < 1.0 for point in compiled.points)


def choose_rows(rows: Any, places: NDArray[np.intp]) -> Any:
    """Return the rows at ascending places that a run reached."""
    if len(rows) == len(places) > places[-1]:
        return rows
    reached = places[: places.searchsorted(len(rows))]
    return rows.take(reached, 0) if hasattr(rows, "dtype") else [rows[k] for k in reached.tolist()]


@lru_cache(16)
def choose_samples(count: int, skipped: int = 0) -> NDArray[np.intp]:
    """Return the indices of about `FEW` compared samples, both ends included.

    For a run that continues after the sample `skipped`, return indices of the whole run.
    """
    whole = count + skipped
    every = max(1, math.ceil((whole - 1) / (FEW - 1)))
    return np.array(sorted({0, *(k - skipped for k in range(0, whole, every) if k > skipped), count - 1}))


def choose_times(times: Sequence[float], skipped: int = 0) -> SampleTimes:
    """Return the compared samples [s], kept with `times`; see `choose_samples`."""
    kept = times.chosen if isinstance(times, SampleTimes) else {}
    if skipped not in kept:
        places: list[int] = choose_samples(len(times), skipped).tolist()
        kept[skipped] = SampleTimes(times[place] for place in places)
    return kept[skipped]


def find_gaps(compiled: CompiledMarch, before: Any, rows: Any) -> Numbers:
    """Return the differences of judged outputs of two passes, (samples, judged), up to the end of the shorter pass."""
    count = min(len(before), len(rows))
    gaps = np.subtract(before[:count], rows[:count]).reshape(count, -1).take(compiled.judged, 1)
    return np.abs(gaps, out=gaps)


def bound_error(compiled: CompiledMarch, run: MarchResult) -> float:
    """Return the largest gap plus the neglected errors, as a fraction of ranges."""
    gaps = run.largest or [math.inf] * len(run.ranges)
    ranges = [max(span, least) for span, (_, least) in zip(run.ranges, compiled.convergence_scales, strict=True)]
    shares = [gap / (span or math.nan) for gap, span in zip(gaps, ranges, strict=True)]
    if not math.isfinite(sum(shares)):
        return math.inf
    worst, heat = max(shares, default=0.0), ranges[0] if ranges else 1.0
    total = max(ERROR_SAFETY * worst + run.ripple / heat, ERROR_SAFETY * run.residual, LEAST_ACCURACY)
    return total if math.isfinite(total) else math.inf
