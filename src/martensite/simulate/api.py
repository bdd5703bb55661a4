"""`simulate`: one run, to a tolerance, with an estimate of what was reached."""

from __future__ import annotations

import math

from martensite.errors import InputError, ParameterError, suggestion
from martensite.signals.base import AbstractWaveform
from martensite.simulate.compiled import Compiled, compile_system
from martensite.simulate.grid import Grid, build_grid
from martensite.simulate.march import Track, march_floats
from martensite.simulate.result import Result
from martensite.simulate.warnings import warnings_of
from martensite.status import Status
from martensite.system import System

RUNTIMES = ("floats", "jax", "c")
JUDGED = {"temperature": 1.0, "martensite_fraction": 0.01, "position": 1e-6}
"""Columns whose convergence is judged, with the least range that counts."""
HALVINGS = 14


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
    compiled = compile_system(system)

    def run(longest: float) -> tuple[Grid, Track]:
        at_end = system.source.sets_temperature
        grid = build_grid(waveform, duration, samples, longest, at_end)
        return grid, _march(runtime, compiled, system, grid)

    if step is not None:
        grid, result = run(step)
        accuracy = None
    else:
        grid, result, accuracy = _refine(run, first_step(system, duration, samples), tolerance)
    return _result(system, waveform, grid, result, accuracy).require()


def first_step(system: System, duration: float, samples: int) -> float:
    """A first guess of the step [s]: a tenth of the thermal time constant, or a sample."""
    from martensite.runtimes import floats

    element, environment = system.element, system.environment
    warm = environment.temperature + 50.0
    lost = element.heat_loss(floats, warm, environment) / 50.0
    constant = element.heat_capacity_total() / lost if lost > 0.0 else math.inf
    return min(0.1 * constant, duration / (samples - 1))


def _refine(run: object, step: float, tolerance: float) -> tuple[Grid, Track, float]:
    """Halve the step until halving changes little; return the finest run."""
    grid, coarse = run(step)  # type: ignore[operator]
    accuracy = math.inf
    for _ in range(HALVINGS):
        step = 0.5 * min(step, grid.longest)
        grid, fine = run(step)  # type: ignore[operator]
        accuracy = _difference(coarse, fine)
        if accuracy <= tolerance and not fine.status.failed:
            calm = fine.status if fine.status.failed else Status.OK
            return grid, Track(fine.rows, calm, fine.status_time), accuracy
        coarse = fine
    return grid, coarse, accuracy


def _difference(coarse: Track, fine: Track) -> float:
    """Largest difference of the judged columns as a share of their range."""
    from martensite.system import OUTPUTS

    worst = 0.0
    for name, least in JUDGED.items():
        i = list(OUTPUTS).index(name)
        a, b = [row[i] for row in coarse.rows], [row[i] for row in fine.rows]
        apart = max(abs(x - y) for x, y in zip(a, b, strict=True))
        worst = max(worst, apart / max(max(b) - min(b), least))
    return worst if math.isfinite(worst) else math.inf


def _march(runtime: str, compiled: Compiled, system: System, grid: Grid) -> Track:
    values = compiled.values(system)
    if runtime == "floats":
        return march_floats(compiled.program.bind_floats(*values), compiled.size, grid)
    if runtime == "c":
        from martensite.simulate.native import march_c

        return march_c(compiled, values, grid)
    from martensite.simulate.batch import march_jax

    return march_jax(compiled, values, grid)


def _result(
    system: System, waveform: AbstractWaveform, grid: Grid, track: Track, accuracy: float | None
) -> Result:
    names = compile_system(system).outputs
    columns = {name: [row[i] for row in track.rows] for i, name in enumerate(names)}
    result = Result(
        system, waveform, grid.times, columns, track.status, track.status_time,
        len(grid.lengths), grid.longest, accuracy,
    )  # fmt: skip
    result.warnings.extend(warnings_of(result))
    return result


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
