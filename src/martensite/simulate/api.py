"""`simulate`: one run to a tolerance, with a bound on the remaining error."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import PROFILES, AbstractSystem
from martensite.base.errors import InputError, ParameterError, suggest_name
from martensite.base.remember_results import remember
from martensite.base.status import Status
from martensite.kernels import floats
from martensite.simulate.accuracy import RunEngine, Tell, choose_rows, choose_times, march_to, require_budget
from martensite.simulate.alarms import judge_limits
from martensite.simulate.compiled import CompiledMarch, bind_march, compile_march, list_values, name_outputs
from martensite.simulate.drive_waveforms import Waveforms, arrange_waveforms, grid_of
from martensite.simulate.envelope import describe_exit, envelope_of, rows_inside
from martensite.simulate.forks import describe_decision
from martensite.simulate.grid import TimeGrid
from martensite.simulate.ledger import HeatBalance, WorkBalance, balance_heat, balance_work
from martensite.simulate.march import Border, march_floats
from martensite.simulate.marching import MarchPlan, MarchResult, Row
from martensite.simulate.restarts import HOME, Relay, Restart, list_samples, place_stops, tabulate_times
from martensite.simulate.result import Result
from martensite.simulate.start_report import describe_start
from martensite.simulate.stops import end_at_envelope
from martensite.simulate.tracing import AbstractTrace, RowsTrace, RunTrace

LOOKS = 50
"""Number of clock readings in a discrete-time run with a budget."""
RUNTIMES = ("auto", "floats", "c")


def simulate(
    system: AbstractSystem,
    waveform: Waveforms,
    duration: float,
    *,
    tolerance: float = 1e-4,
    step: float | None = None,
    samples: int = 1001,
    runtime: str = "auto",
    budget: float | None = None,
    tell: Tell | None = None,
    start: Restart = HOME,
    restart_at: Sequence[float] = (),
) -> Result:
    """Simulate a system under a waveform up to `duration` [s], by default from equilibrium.

    Drives are integrated over every step, and the step size is controlled (`martensite.simulate.adaptive`). The run
    is repeated with different local tolerances; `Result.accuracy` bounds the remaining error. A system in discrete
    time has fixed steps and reads waveforms at their starts.

    A run that leaves the physical envelope stops with the status OUT_OF_ENVELOPE. Its columns and balances end at
    that time.

    Args:
        system: a `System` of one element, or a `Machine` of several.
        waveform: drive signal in the unit of the source, or a table of signals by drive name.
        duration: end of the run [s], counted from 0 also for a later start.
        tolerance: accepted error of temperatures, martensite fractions, stresses and coordinates, as a fraction of
            each range. The smallest ranges are 1 K, 0.01, 1 MPa, and values of the mechanism.
        step: longest step [s] of a single run with equal steps between samples and edges, without error estimation.
        samples: number of equidistant samples from 0 to `duration`; a later start omits earlier samples.
        runtime: `floats`, `c` (compiled on demand), or `auto`: floats for short runs, else C with a compiler.
        budget: maximum CPU time [s]; unlimited by default.
        tell: progress callback with the activity and the completed fraction.
        start: initial time and state (`martensite.simulate.restarts`).
        restart_at: times [s] of stored restart states, besides the end. A step ends there, and the solver restarts.

    Raises:
        InputError: an argument is out of range.
        SolveError: the run failed or exceeded its budget; the message gives the time and a remedy.
    """
    check_run(duration, tolerance, step, samples)
    if runtime == "cuda":
        raise InputError("The runtime `cuda` runs batches; give `over`, or use the runtime `c`.")
    if runtime not in RUNTIMES:
        raise InputError(f"No runtime named `{runtime}`. {suggest_name(runtime, RUNTIMES)}")
    waves = arrange_waveforms(system, waveform)
    if system.sample_time():
        return _in_discrete_time(system, waveform, duration, samples, runtime, start, restart_at, budget)
    compiled = compile_march(system)
    times = list_samples(duration, samples, start.time)
    plan = MarchPlan(
        compiled,
        waves,
        times,
        tolerance,
        first_step(system, duration, samples),
        envelope_of(system),
        step=step,
        inertial=inertial_step(system),
        skipped=samples - len(times),
    )
    engine = RunEngine(compiled, list_values(system), runtime, tell, budget)
    relay = Relay(engine, start, place_stops(restart_at, times))

    def march(relay: Relay, plan: MarchPlan) -> tuple[MarchResult, float | None]:
        return march_to(relay, plan, tolerance) if step is None else (relay(plan), None)

    def march_again(plan: MarchPlan) -> tuple[MarchResult, float | None]:
        return march(Relay(engine, start, [stop for stop in relay.stops if stop < plan.times[-1]]), plan)

    plan, run, accuracy = end_at_envelope(system, plan, *march(relay, plan), march_again)
    restarts = relay.list_restarts(choose_times(times, plan.skipped) if step is None else times[-1:])
    notes: list[str] = []
    if run.undecided:
        name, _ = compiled.convergence_scales[compiled.forks[run.decision.place].fraction]
        notes.append(describe_decision(run.decision, run.undecided, name.rpartition(".")[0]))
    elif accuracy is not None and accuracy > tolerance and not run.status.failed:
        notes.append(
            f"Warning: the tolerance of {tolerance:.1e} was not reached in {run.steps:,} steps; "
            f"what is judged may be off by {accuracy:.1e} of its range."
        )
    context = _RunContext(waveform, RunTrace(system, engine, plan, run, relay), start, restarts, notes, accuracy)
    return _build_result(system, plan, run, context)


def _in_discrete_time(
    system: AbstractSystem,
    waveform: Waveforms,
    duration: float,
    samples: int,
    runtime: str,
    start: Restart,
    restart_at: Sequence[float],
    budget: float | None,
) -> Result:
    compiled, interval = compile_march(system), system.sample_time()
    whole = grid_of(system, waveform, duration, samples, interval, every=True)
    grid = whole.cut(start.time, whole.times[-1])
    begin = time.process_time()

    def march(plan: MarchPlan) -> MarchResult:
        require_budget(budget, begin, plan.times[0] / grid.times[-1])
        leg = whole.cut(plan.times[0], plan.times[-1])
        run = _march_grid(system, compiled, leg, runtime, plan.start).require()
        run.steps, run.longest = len(leg.lengths), leg.longest
        return run

    plan = MarchPlan(compiled, (), grid.times, 0.0, interval, envelope_of(system))
    stops = place_stops(restart_at, grid.times)
    looks = [] if budget is None else grid.times[1 : -1 : math.ceil(len(grid.times) / LOOKS)]
    relay = Relay(march, start, sorted({*stops, *looks}))
    run = relay(plan)
    if run.status is Status.OUT_OF_ENVELOPE:
        run.rows = list(rows_inside(system, run.rows))
    restarts = relay.list_restarts(grid.times[-1:]) if run.state else []
    restarts = [one for one in restarts if one.time in {*stops, grid.times[-1]}]
    kept_all = whole.stored is not ...
    trace = RowsTrace(grid.times[: len(run.rows)], run.rows, len(name_outputs(system))) if kept_all else None
    times, stored = np.asarray(grid.times), np.asarray(whole.times)[whole.stored]
    places = np.flatnonzero(np.isin(times, [start.time, *stored]))
    kept: Any = times[places]
    plan = plan._replace(times=kept)
    run = replace(run, rows=choose_rows(run.rows, places), runtime="C" if runtime == "c" else "floats")
    notes = list[str]()
    if not kept_all and len(whole.lengths) > len(whole.times):
        notes.append(
            f"Caution: the run has {len(whole.lengths):,} steps; its measures and alarms come from "
            f"{len(whole.times):,} stored samples."
        )
    return _build_result(system, plan, run, _RunContext(waveform, trace, start, restarts, notes))


def _march_grid(
    system: AbstractSystem, compiled: CompiledMarch, grid: TimeGrid, runtime: str, start: Row = ()
) -> MarchResult:
    """Run on given steps; repeat a failed run on floats, which report time and place."""
    run: MarchResult | None = None
    limits = envelope_of(system)
    if runtime == "c":
        from martensite.simulate.native import march_c

        run = march_c(compiled, list_values(system), grid, limits, start)
    if run is None or run.status.failed:
        functions, size = bind_march(system)
        run = march_floats(functions, size, grid, Border(compiled, functions, limits), start)
    return run


def first_step(system: AbstractSystem, duration: float, samples: int) -> float:
    """Return a first guess of the step [s]: the longest sensible step or a sample."""
    return min(longest_step(system), duration / (samples - 1))


def inertial_step(system: AbstractSystem) -> float:
    """Return the first step of a system with inertia [s]; 0 without inertia."""
    first = system.mechanism.first_step()
    return first if math.isfinite(first) else 0.0


def steps_in(system: AbstractSystem, time: float) -> int:
    """Return the number of sensible steps in a time [s], at least 1."""
    return max(1, math.ceil(time / longest_step(system) - 1e-9))


@remember
def longest_step(system: AbstractSystem) -> float:
    """Return a tenth of the smallest thermal time constant [s], or the limit of the mechanism."""
    constants: list[float] = []
    for one in system.actuators().values():
        warm = one.environment.temperature + 50.0
        lost = one.element.heat_loss(floats, warm, one.environment) / 50.0
        if lost > 0.0:
            constants.append(0.1 * one.element.heat_capacity_total() / lost)
    return min([*constants, system.mechanism.first_step()])


class _RunContext(NamedTuple):
    """Parts of a result that do not depend on the time integration."""

    waveform: Waveforms
    trace: AbstractTrace | None
    start: Restart
    restarts: list[Restart]
    notes: list[str]
    accuracy: float | None = None


def _build_result(system: AbstractSystem, plan: MarchPlan, run: MarchResult, context: _RunContext) -> Result:
    names, book = name_outputs(system), plan.compiled.book
    columns = np.array(np.asarray(run.require().rows, float).T, order="C")
    notes: list[str] = []
    heat = work = None
    balanced = plan.step is None and not system.sample_time()
    if balanced:
        heat = balance_heat(run.put_in, run.lost, run.accounts) if book.has_heat_balance else None
        work = balance_work(book, run.accounts) if book.has_work_balance else None
        notes = _warn_of_residuals(heat, work, plan.tolerance)
    if run.status is Status.OUT_OF_ENVELOPE:
        notes.append(describe_exit(system, run.time, run.place, run.value))
    return Result(
        system,
        context.waveform,
        tabulate_times(plan.times)[: columns.shape[1]].copy(),
        dict(zip(names, columns, strict=False)),
        run.status,
        run.status_time,
        run.steps,
        run.longest,
        context.accuracy,
        notes=[*notes, *context.notes],
        judged=judge_limits,
        profiles=_part_profiles(columns[len(names) :]),
        runtime=run.runtime,
        rejected=run.rejected,
        heat=heat,
        work=work,
        unbalanced=list(book.unknown) if balanced else [],
        ripple=run.ripple,
        trace=context.trace,
        begin=partial(describe_start, context.start),
        restarts=context.restarts,
    )


def _warn_of_residuals(heat: HeatBalance | None, work: WorkBalance | None, tolerance: float) -> list[str]:
    """Return a warning for each balance with a large residual."""
    residuals = [(words, one.residual) for words, one in (("heat", heat), ("work", work)) if one is not None]
    return [
        f"Warning: {residual:.1e} of the {words} is not accounted for, more than the tolerance of {tolerance:.1e}."
        for words, residual in residuals
        if residual is not None and not residual <= tolerance
    ]


def check_run(duration: float, tolerance: float, step: float | None, samples: int) -> None:
    """Raise `ParameterError` for an argument out of range."""
    for name, value in (("duration", duration), ("tolerance", tolerance), ("step", step)):
        if value is not None and not (0.0 < value < math.inf):
            raise ParameterError(f"Argument `{name}` must be above 0, but is {value}.")
    if samples < 2:
        raise ParameterError(f"Argument `samples` must be at least 2, but is {samples}.")


def _part_profiles(columns: NDArray[np.float64]) -> dict[str, list[list[float]]]:
    """Return the profiles in columns behind the outputs."""
    parts = columns.reshape(len(PROFILES), -1, columns.shape[1])
    return dict(zip(PROFILES, parts.tolist(), strict=True)) if len(columns) else {}
