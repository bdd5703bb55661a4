"""Entry point `run` for a file, a scenario, a system or a bench."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from martensite.actuators.assembly.base import AbstractSystem
from martensite.base import units
from martensite.base.errors import InputError
from martensite.scenario.scenario import Scenario, load

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from martensite.simulate.drive_waveforms import Waveforms
    from martensite.simulate.result import Result

Over = Mapping[str, "Sequence[units.Numeric] | NDArray[Any]"]
"""One value per variant, by parameter path or its unique ending: SI, text with a unit, or a quantity of pint."""


def run(
    what: str | Path | Scenario | AbstractSystem,
    drive: Waveforms | None = None,
    duration: units.Numeric | None = None,
    *,
    over: Over | None = None,
    tolerance: float | None = None,
    step: float | None = None,
    samples: int | None = None,
    outputs: Sequence[str] | None = None,
    runtime: str = "auto",
    budget: float | None = None,
    tell: Callable[[str, float], None] | None = None,
    initial: Mapping[str, Any] | None = None,
    start: Result | str | Path | None = None,
    at: units.Numeric | None = None,
    restart_at: Sequence[units.Numeric] = (),
) -> Result:
    """Simulate a scenario or a system, once or as a batch of variants.

        ms.run("finger.toml").plot()
        ms.run(scenario, over={"mass": ["0.3 kg", "0.5 kg"]})["position"]   # (2, samples)
        ms.run(ms.System(...), ms.Step(high=0.4, at=1.0), "30 s")

    Args:
        what: path of a scenario file, a scenario, or a `System`, a `Machine` or a bench. A system needs a `drive` and a
            `duration`, a bench with built-in signals only a `duration`.
        drive: waveform in the unit of the source, or several by name; replaces the one of the scenario.
        duration: end of the run, in seconds from 0 or as text with a unit; replaces the one of the scenario.
        over: variants of a batch: equally many values per parameter path (or unique ending), in SI or as text.
        tolerance: accepted error of temperatures, martensite fractions, stresses and coordinates, as a share of their
            ranges; by default 1e-4 or as in the scenario.
        step: longest step [s]; steps are then equal and no error is estimated.
        samples: number of equidistant samples, both ends included, by default 1001 or as in the scenario.
        outputs: returned columns of a batch, by default those whose accuracy is judged.
        runtime: `floats`, `c` or `auto`, the fastest available; also `cuda` for a batch.
        budget: CPU time [s] after which a single run is given up.
        tell: called repeatedly with the current activity and the finished fraction.
        initial: initial state as in [initial], by default equilibrium or as in the scenario.
        start: result of the same system, or its file, from which the run continues at its own time.
        at: time of that restart, in seconds or as text, by default the end.
        restart_at: further times at which the result keeps a state.

    Raises:
        InputError: an argument is out of range or of the wrong kind.
        SolveError: a single run failed; the message says when and what to try.
    """
    if isinstance(what, str | Path):
        what = load(what)
    if not isinstance(what, Scenario | AbstractSystem):
        raise TypeError("neither a scenario nor a system")
    seconds = None if duration is None else units.convert_number(duration, "s")
    scenario = _change_settings(_arrange_scenario(what, drive, seconds), tolerance, step, samples)
    if initial is not None:
        from martensite.simulate.initial import read_initial

        scenario = replace(scenario, initial=read_initial(scenario.whole, initial))
    if restart_at:
        scenario = replace(scenario, restart_at=tuple(units.convert_number(one, "s") for one in restart_at))
    if start is not None:
        scenario = go_on_from(scenario, start, at)
    elif at is not None:
        raise InputError(
            "Argument `at` of `run` sets the time at which a run continues. Add the result to `start` from."
        )
    if over is not None:
        return _run_batch(scenario, over, outputs, runtime)
    if outputs is not None:
        raise InputError("Argument `outputs` of `run` is for batches; give `over` with it.")
    if scenario.bench is None:
        return scenario.run(runtime=runtime, budget=budget, tell=tell)
    return scenario.run(runtime=None if runtime == "auto" else runtime, budget=budget, tell=tell)


def go_on_from(scenario: Scenario, what: Result | str | Path, at: units.Numeric | None = None) -> Scenario:
    """Return a scenario that continues a result, or its file, at a time [s] or text; by default at its end.

    Raises:
        DataError: the file holds no result.
        InputError: no state was stored at that time, the state is invalid, or the system differs.
    """
    from martensite.simulate.restarts import find_restart, require_names, require_sound
    from martensite.simulate.result import Result

    if isinstance(what, Result):
        restarts, names = what.restarts, what.state_names
    else:
        from martensite.scenario.netcdf import read_labelled, read_restarts

        restarts, names = read_restarts(read_labelled(what))
    restart = find_restart(restarts, None if at is None else units.convert_number(at, "s"))
    require_names(scenario.whole, names)
    require_sound(names, restart)
    return replace(scenario, start=restart)


def _arrange_scenario(what: Scenario | AbstractSystem, drive: Waveforms | None, duration: float | None) -> Scenario:
    from martensite.control.loop.bench import Bench

    if isinstance(what, Scenario):
        new: dict[str, Any] = {"waveform": drive, "duration": duration}
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


def _change_settings(scenario: Scenario, tolerance: float | None, step: float | None, samples: int | None) -> Scenario:
    settings = {"tolerance": tolerance, "samples": samples}
    changes: dict[str, Any] = {name: value for name, value in settings.items() if value is not None}
    if step is not None or tolerance is not None:
        changes["step"] = step
    return replace(scenario, **changes)


def _run_batch(scenario: Scenario, over: Over, outputs: Sequence[str] | None, runtime: str) -> Result:
    from martensite.simulate.batch import simulate_batch

    if scenario.bench is not None:
        raise InputError("A bench has no batches in `run`; take `ms.design.run_sweep`.")
    if scenario.require_home("Every run of a batch").restart_at:
        raise InputError("Runs of a batch keep no states; give `over` without restarts.")
    system = scenario.system
    return simulate_batch(
        system,
        scenario.waveform,
        scenario.duration,
        _convert_variants(system, over),
        tolerance=scenario.tolerance,
        step=scenario.step,
        samples=scenario.samples,
        outputs=(outputs,) if isinstance(outputs, str) else tuple(outputs or system.convergence_scales()),
        runtime=runtime,
    )


def _convert_variants(system: AbstractSystem, over: Over) -> dict[str, Sequence[float]]:
    """Return the values by full path in SI; `simulate_batch` checks the ranges of plain numbers."""
    leaves: dict[str, Any] = {leaf.path: leaf for leaf in system.leaves()}
    if not len(over):
        raise InputError('`over` is empty; name a parameter and its values, as in `over={"diameter": [2e-4, 3e-4]}`.')
    variants: dict[str, Sequence[float]] = {}
    for name, values in over.items():
        leaf, listed = leaves[system.resolve(str(name))], cast("Any", values)
        if isinstance(listed, str) or not hasattr(listed, "__len__"):
            raise InputError(
                f"`over` needs a list of values for `{name}`, one for each variant, but has {listed!r}; "
                f'write `over={{"{name}": [{listed!r}]}}`.'
            )
        plain = all(issubclass(one, float) for one in set(map(type, listed)))
        convert = partial(leaf.declared.convert, leaf.owner, leaf.path)
        variants[leaf.path] = listed if plain else list(map(convert, listed))
    return variants
