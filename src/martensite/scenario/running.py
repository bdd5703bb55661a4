"""`run`: a file, a scenario, a system or a bench, for one run or a batch of variants."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from martensite.actuators.assembly.base import AbstractSystem
from martensite.base import units
from martensite.base.errors import InputError
from martensite.scenario.scenario import Scenario, load

if TYPE_CHECKING:
    from martensite.simulate.drive_waveforms import Waveforms
    from martensite.simulate.result import Result

Over = Mapping[str, Sequence[float | str]]
"""By parameter path, or a unique ending of it, one value per variant: SI, or text with a unit."""


def run(
    what: str | Path | Scenario | AbstractSystem,
    drive: Waveforms | None = None,
    duration: float | str | None = None,
    *,
    over: Over | None = None,
    tolerance: float | None = None,
    step: float | None = None,
    samples: int | None = None,
    outputs: Sequence[str] | None = None,
    runtime: str = "auto",
    budget: float | None = None,
    tell: Callable[[str, float], None] | None = None,
) -> Result:
    """Simulate.

        ms.run("finger.toml").plot()
        ms.run(scenario, over={"mass": ["0.3 kg", "0.5 kg"]})["position"]   # (2, samples)
        ms.run(ms.System(...), ms.Step(high=0.4, at=1.0), "30 s")

    Args:
        what: the path of a scenario file, a scenario, or a `System`, a `Machine` or a bench, which
            need a `drive` (a bench without signals of its own does not) and a `duration`.
        drive: waveform in the unit of the source, or a table of them by name; of a scenario, in place of its own.
        duration: length of the run, in seconds or as text with a unit; likewise.
        over: runs a batch: by parameter path (or unique ending) one value per variant, in SI or
            as text with a unit; all of them equally many.
        tolerance: accepted error of temperatures, martensite fractions, stresses and coordinates,
            as a share of their ranges; 1e-4, or what the scenario says.
        step: longest step [s]; if given, steps are equal and nothing is estimated.
        samples: number of equidistant samples, both ends included; 1001, or as the scenario says.
        outputs: of a batch, the columns to return; by default those whose accuracy is judged.
        runtime: `floats`, `c`, `jax`, or `auto`, which is the fastest there is; of a batch also `cuda`.
        budget: CPU time [s] after which a single run is given up.
        tell: called now and then with what is being done and which share of it.

    Raises:
        InputError: an argument is out of range, or of the wrong kind.
        SolveError: a single run failed; the sentence says when and what to try.
    """
    if isinstance(what, str | Path):
        what = load(what)
    if not isinstance(what, Scenario | AbstractSystem):
        raise TypeError("neither a scenario nor a system")
    seconds = units.parse_quantity(duration, "s") if isinstance(duration, str) else duration
    scenario = _arrange_scenario(what, drive, seconds)
    changed = {"tolerance": tolerance, "samples": samples}
    given = {name: value for name, value in changed.items() if value is not None}
    if step is not None or tolerance is not None:
        given["step"] = step
    scenario = replace(scenario, **given)
    if over is not None:
        return _run_batch(scenario, over, outputs, runtime)
    if outputs is not None:
        raise InputError("Argument `outputs` of `run` is for batches; give `over` with it.")
    if scenario.bench is None:
        return scenario.run(runtime=runtime, budget=budget, tell=tell)
    return scenario.run(runtime=None if runtime == "auto" else runtime, tell=tell)


def _arrange_scenario(what: Scenario | AbstractSystem, drive: Waveforms | None, duration: float | None) -> Scenario:
    from martensite.control.loop.bench import Bench

    if isinstance(what, Scenario):
        new = {"waveform": drive, "duration": duration}
        return replace(what, **{name: value for name, value in new.items() if value is not None})
    bench = what if isinstance(what, Bench) else None
    if duration is None or (drive is None and bench is None):
        raise InputError(
            "A system runs under a `drive` for a `duration`; write for example "
            '`run(system, ms.Step(high=0.4, at=1.0), "30 s")`.'
        )
    return Scenario(
        system=what if bench is None else bench.plant,
        waveform={} if drive is None else drive,
        duration=duration,
        tolerance=1e-4,
        samples=1001,
        step=None,
        title=what.description(),
        text="",
        path=None,
        material=None,
        bench=bench,
    )


def _run_batch(scenario: Scenario, over: Over, outputs: Sequence[str] | None, runtime: str) -> Result:
    from martensite.simulate.batch import simulate_batch

    if scenario.bench is not None:
        raise InputError("A bench has no batches in `run`; take `ms.design.run_sweep`.")
    system = scenario.system
    return simulate_batch(
        system,
        scenario.waveform,
        scenario.duration,
        _convert_variants(system, over),
        tolerance=scenario.tolerance,
        step=scenario.step,
        samples=scenario.samples,
        outputs=tuple(outputs or system.convergence_scales()),
        runtime=runtime,
    )


def _convert_variants(system: AbstractSystem, over: Over) -> dict[str, list[float]]:
    leaves: dict[str, Any] = {leaf.path: leaf for leaf in system.leaves()}
    found: dict[str, list[float]] = {}
    for name, values in over.items():
        leaf = leaves[system.resolve(name)]
        found[leaf.path] = [leaf.declared.convert(leaf.owner, leaf.path, one) for one in values]
    return found
