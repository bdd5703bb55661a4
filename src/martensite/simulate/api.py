"""`simulate`: one run, to a tolerance, with an estimate of what was reached."""

from __future__ import annotations

import math
from dataclasses import dataclass

from martensite.errors import InputError, ParameterError, suggestion
from martensite.runtimes import floats
from martensite.runtimes.bracket import ITERATIONS
from martensite.signals.base import AbstractWaveform
from martensite.simulate.compiled import Compiled, compile_system
from martensite.simulate.grid import Grid, build_grid, require_unit
from martensite.simulate.march import Track, march_floats
from martensite.simulate.result import Result, profiles_of
from martensite.simulate.warnings import add_warnings
from martensite.status import Status
from martensite.system import OUTPUTS, System

RUNTIMES = ("floats", "jax", "c")
JUDGED = {"temperature": 1.0, "martensite_fraction": 0.01, "position": 1e-6}
"""Columns whose convergence is judged, with the least range that counts."""
HALVINGS = 14
MOST_REFINED = 4_000_000
"""Steps beyond which a run is not refined further, but returned with a warning."""
THOROUGH = 24
"""Iterations of the solve when the usual few leave a step unsolved: kinks, strong pulses."""


def simulate(
    system: System,
    waveform: AbstractWaveform,
    duration: float,
    *,
    tolerance: float = 1e-4,
    step: float | None = None,
    samples: int = 1001,
    runtime: str = "floats",
) -> Result:
    """Run a system from rest under a waveform for `duration` [s].

    Steps end on the edges of the waveform and are halved until halving changes temperature,
    martensite fraction and position by less than `tolerance` times their range.

    Args:
        system: element, environment, source and mechanism.
        waveform: drive signal in the unit of the source.
        duration: length of the run [s].
        tolerance: accepted change on halving, as a share of range.
        step: longest step [s]; if given, one run is made with it and nothing is estimated.
        samples: number of equidistant samples returned, both ends included.
        runtime: floats (default), jax, or c (compiled on the spot); all agree to 1e-12.

    Raises:
        InputError: an argument is out of range.
        SolveError: the run failed; the sentence says when and what to try.
    """
    _check(duration, tolerance, step, samples, runtime)
    require_unit(waveform, system.source.unit)
    run = _Runner(system, waveform, duration, samples, runtime)
    if step is not None:
        grid, track = run(step)
        return _result(run, grid, track.require(), None)
    grid, track, accuracy = _refine(run, first_step(system, duration, samples), tolerance)
    result = _result(run, grid, track.require(), accuracy)
    if accuracy > tolerance:
        result.warnings.append(
            f"Warning: the tolerance of {tolerance:.1e} was not reached in {result.steps:,} "
            f"steps; halving still changes the result by {accuracy:.1e} of its range."
        )
    return result


@dataclass(frozen=True)
class _Runner:
    """Everything about a run but its step."""

    system: System
    waveform: AbstractWaveform
    duration: float
    samples: int
    runtime: str

    def __call__(self, step: float) -> tuple[Grid, Track]:
        at_end = self.system.source.sets_temperature
        grid = build_grid(self.waveform, self.duration, self.samples, step, at_end)
        track = self._march(self.runtime, grid, ITERATIONS)
        if track.status is Status.UNSOLVED:
            track = self._march(self.runtime, grid, THOROUGH)
        if track.status.failed and track.status_time is None:
            track = self._march("floats", grid, THOROUGH)  # the one that records when
        return grid, track

    def _march(self, runtime: str, grid: Grid, iterations: int) -> Track:
        compiled = compile_system(self.system, iterations)
        return _march(runtime, compiled, compiled.values(self.system), grid)


def first_step(system: System, duration: float, samples: int) -> float:
    """A first guess of the step [s]: a tenth of the thermal time constant, or a sample."""
    element, environment = system.element, system.environment
    warm = environment.temperature + 50.0
    lost = element.heat_loss(floats, warm, environment) / 50.0
    constant = element.heat_capacity_total() / lost if lost > 0.0 else math.inf
    return min(0.1 * constant, duration / (samples - 1))


def _refine(run: _Runner, step: float, tolerance: float) -> tuple[Grid, Track, float]:
    """Halve the step until halving changes little; return the finest run."""
    grid, coarse = run(step)
    accuracy = math.inf
    for _ in range(HALVINGS):
        if 2 * len(grid.lengths) > MOST_REFINED:
            break
        step = 0.5 * min(step, grid.longest)
        grid, fine = run(step)
        accuracy = _difference(coarse, fine)
        if accuracy <= tolerance and not fine.status.failed:
            return grid, Track(fine.rows, Status.OK, 0.0), accuracy
        coarse = fine
    return grid, coarse, accuracy


def _difference(coarse: Track, fine: Track) -> float:
    """Largest difference of the judged columns as a share of their range."""
    if len(coarse.rows) != len(fine.rows):
        return math.inf
    worst = 0.0
    for name, least in JUDGED.items():
        i = list(OUTPUTS).index(name)
        a, b = [row[i] for row in coarse.rows], [row[i] for row in fine.rows]
        apart = max(abs(x - y) for x, y in zip(a, b, strict=True))
        worst = max(worst, apart / max(max(b) - min(b), least))
    return worst if math.isfinite(worst) else math.inf


def _march(runtime: str, compiled: Compiled, values: list[float], grid: Grid) -> Track:
    if runtime == "floats":
        return march_floats(compiled.program.bind_floats(*values), compiled.size, grid)
    if runtime == "c":
        from martensite.simulate.native import march_c

        return march_c(compiled, values, grid)
    from martensite.simulate.batch import march_jax

    return march_jax(compiled, values, grid)


def _result(run: _Runner, grid: Grid, track: Track, accuracy: float | None) -> Result:
    columns = {name: [row[i] for row in track.rows] for i, name in enumerate(OUTPUTS)}
    result = Result(
        run.system, run.waveform, grid.times, columns, track.status, track.status_time,
        len(grid.lengths), grid.longest, accuracy, profiles=profiles_of(track.rows),
    )  # fmt: skip
    return add_warnings(result)


def _check(
    duration: float, tolerance: float, step: float | None, samples: int, runtime: str
) -> None:
    for name, value in (("duration", duration), ("tolerance", tolerance), ("step", step)):
        if value is not None and not (0.0 < value < math.inf):
            raise ParameterError(f"Argument `{name}` must be above 0, but is {value}.")
    if samples < 2:
        raise ParameterError(f"Argument `samples` must be at least 2, but is {samples}.")
    if runtime not in RUNTIMES:
        raise InputError(f"No runtime named `{runtime}`. {suggestion(runtime, RUNTIMES)}")
