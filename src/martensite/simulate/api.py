"""`simulate`: one run, to a tolerance, with an estimate of what was reached."""

from __future__ import annotations

import math
from dataclasses import dataclass

from martensite.errors import InputError, ParameterError, suggestion
from martensite.runtimes import floats
from martensite.simulate.compiled import bind_system, compile_system
from martensite.simulate.driven import Waveforms, arranged, grid_of
from martensite.simulate.grid import Grid
from martensite.simulate.march import Track, march_floats
from martensite.simulate.result import Result, profiles_of
from martensite.simulate.warnings import add_warnings
from martensite.status import Status
from martensite.system import AbstractSystem

RUNTIMES = ("floats", "jax", "c")
HALVINGS = 14
MOST_REFINED = 4_000_000
"""Steps beyond which a run is not refined further, but returned with a warning."""


def simulate(
    system: AbstractSystem,
    waveform: Waveforms,
    duration: float,
    *,
    tolerance: float = 1e-4,
    step: float | None = None,
    samples: int = 1001,
    runtime: str = "floats",
) -> Result:
    """Run a system from rest under a waveform for `duration` [s].

    Steps end on the edges of the waveforms and are halved until halving changes temperatures,
    martensite fractions and coordinates by less than `tolerance` times their range. A system in
    discrete time has steps of its own: waveforms are read at their starts.

    Args:
        system: a `System` of one element, or a `Machine` of several.
        waveform: drive signal in the unit of the source; for a system with several drives a
            table of them by name.
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
    arranged(system, waveform)
    run = _Runner(system, waveform, duration, samples, runtime)
    step = system.sample_time() or step
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

    system: AbstractSystem
    waveform: Waveforms
    duration: float
    samples: int
    runtime: str

    def __call__(self, step: float) -> tuple[Grid, Track]:
        grid = grid_of(self.system, self.waveform, self.duration, self.samples, step)
        if self.runtime == "floats":
            return grid, march_floats(*bind_system(self.system), grid)
        track = self._compiled(grid)
        if track.status.failed:  # floats record when
            track = march_floats(*bind_system(self.system), grid)
        return grid, track

    def _compiled(self, grid: Grid) -> Track:
        compiled = compile_system(self.system)
        values = compiled.values(self.system)
        if self.runtime == "c":
            from martensite.simulate.native import march_c

            return march_c(compiled, values, grid)
        from martensite.simulate.batch import march_jax

        return march_jax(compiled, values, grid)


def first_step(system: AbstractSystem, duration: float, samples: int) -> float:
    """A first guess of the step [s]: the longest one that is sensible, or a sample."""
    return min(longest_step(system), duration / (samples - 1))


def steps_in(system: AbstractSystem, time: float) -> int:
    """Steps into which a time [s] is cut so that none is longer than is sensible; 1 at least."""
    return max(1, math.ceil(time / longest_step(system) - 1e-9))


def longest_step(system: AbstractSystem) -> float:
    """A tenth of the least thermal time constant [s], or what the mechanism can bear."""
    constants: list[float] = []
    for one in system.actuators().values():
        warm = one.environment.temperature + 50.0
        lost = one.element.heat_loss(floats, warm, one.environment) / 50.0
        if lost > 0.0:
            constants.append(0.1 * one.element.heat_capacity_total() / lost)
    return min([*constants, system.mechanism.first_step()])


def _refine(run: _Runner, step: float, tolerance: float) -> tuple[Grid, Track, float]:
    """Halve the step until halving changes little; return the finest run."""
    grid, coarse = run(step)
    accuracy = math.inf
    for _ in range(HALVINGS):
        if 2 * len(grid.lengths) > MOST_REFINED:
            break
        step = 0.5 * min(step, grid.longest)
        grid, fine = run(step)
        accuracy = _difference(run.system, coarse, fine)
        if accuracy <= tolerance and not fine.status.failed:
            return grid, Track(fine.rows, Status.OK, 0.0), accuracy
        coarse = fine
    return grid, coarse, accuracy


def _difference(system: AbstractSystem, coarse: Track, fine: Track) -> float:
    """Largest difference of the judged columns as a share of their range."""
    if len(coarse.rows) != len(fine.rows):
        return math.inf
    worst = 0.0
    names = list(system.outputs())
    for name, least in system.judged().items():
        i = names.index(name)
        a, b = [row[i] for row in coarse.rows], [row[i] for row in fine.rows]
        apart = max(abs(x - y) for x, y in zip(a, b, strict=True))
        worst = max(worst, apart / max(max(b) - min(b), least))
    return worst if math.isfinite(worst) else math.inf


def _result(run: _Runner, grid: Grid, track: Track, accuracy: float | None) -> Result:
    names, rows = list(run.system.outputs()), track.rows
    columns = {name: [row[i] for row in rows] for i, name in enumerate(names)}
    result = Result(
        run.system, run.waveform, grid.times, columns, track.status, track.status_time,
        len(grid.lengths), grid.longest, accuracy, profiles=profiles_of(len(names), rows),
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
