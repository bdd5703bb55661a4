"""Runs of a bench with drawn noise and its references.

A user-defined drive may run outside the kernel: it is called once per period with the readings of the bench. Its
reference and wanted signal are columns of the result, as those of a controller on the bench.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base.errors import InputError
from martensite.base.parameters import part
from martensite.base.remember_results import remember
from martensite.control.checks.base import LIMITED
from martensite.control.controllers.base import AbstractController
from martensite.control.loop.bench import Bench
from martensite.control.loop.findings import check_guard, check_signals
from martensite.control.loop.miss_rule import describe_expected_miss
from martensite.control.loop.names import (
    AGE,
    ALARM,
    JITTER,
    MEASURED,
    NOISE,
    list_hands,
    list_previews,
    list_readings,
    list_references,
    name_controller_outputs,
    outside_references,
    reference_output,
    wanted_name,
    wanted_output,
)
from martensite.control.loop.parts import Controllers
from martensite.control.observers.base import ESTIMATED
from martensite.kernels.compiler import find_compiler
from martensite.signals.ahead import Ahead
from martensite.signals.base import AbstractDrive, AbstractWaveform
from martensite.signals.held import Held
from martensite.simulate.api import simulate
from martensite.simulate.controlled_run import simulate_controlled
from martensite.simulate.drive_waveforms import list_drive_signals
from martensite.simulate.restarts import HOME, Restart

if TYPE_CHECKING:
    from martensite.simulate.result import Result

ROUNDING = 1e-6


def simulate_bench(
    bench: Bench,
    duration: float,
    *,
    outside: Mapping[str, AbstractDrive] | None = None,
    waveforms: Mapping[str, AbstractWaveform] | None = None,
    seed: int | None = 0,
    runtime: str | None = None,
    budget: float | None = None,
    watch: Callable[[float], None] | None = None,
    start: Restart = HOME,
    restart_at: Sequence[float] = (),
) -> Result:
    """Run a bench, by default from the steady state.

    Args:
        bench: plant, sensors, observers, controllers, supervisor and faults.
        duration: end of the run [s], at least a period; a warning reports a rounding to whole periods.
        outside: drives that run outside the kernel, by driven signal, called once per period.
        waveforms: signals of plant drives without a controller, by drive; default: 0.
        seed: seed of noise and jitter; None for a run without noise. The result stores it as `seed`.
        runtime: floats or c; default: c if there is a compiler.
        budget: largest CPU time [s]; not with `outside`.
        watch: called after every period with the completed fraction of the run, with `outside`.
        start: state stored in a result, from which the run continues.
        restart_at: samples [s] at which a state is stored; not with `outside`.

    Raises:
        InputError: a name or unit does not fit.
        SolveError: the run failed; the message gives time and remedy.
    """
    played: dict[str, Any] = {**(waveforms or {}), **reference_waveforms(bench)}
    played |= (noise := noise_waveforms(bench, duration, seed))
    noise_seed = seed if noise else None
    if outside:
        if budget is not None:
            raise InputError("A run whose controllers run outside has no budget.")
        if start is not HOME or restart_at:
            raise InputError("A run whose controllers run outside keeps no states: there is nothing to go on from.")
        seeing = {name: ReadingsOnlyDrive(drive=drive) for name, drive in outside.items()}
        periods = round(duration / bench.period)
        length = periods * bench.period
        result = simulate_controlled(bench, played | seeing, length, bench.period, watch=watch)
        return warn_of_loops(replace(_with_loops(result, bench, outside), seed=noise_seed), bench, duration)
    chosen = runtime or ("c" if find_compiler() is not None else "floats")
    samples = int(duration / bench.period + 1e-6) + 1
    result = simulate(
        bench,
        played,
        duration,
        samples=max(samples, 2),
        runtime=chosen,
        budget=budget,
        start=start,
        restart_at=restart_at,
    )
    return warn_of_loops(replace(result, seed=noise_seed), bench, duration)


def warn_of_loops(result: Result, bench: Bench, duration: float) -> Result:
    """Return the result with warnings about guard, controllers, impossible signals, and the end [s]."""
    noted = _with_doubts(warn_of_guard(result, bench), bench)
    return warn_of_end(replace(noted, notes=[*noted.notes, *_list_faults(bench)]), duration, bench.period)


@remember
def _list_faults(bench: Bench) -> list[str]:
    """Return warnings about impossible signals and limits of the guard."""
    findings = (*check_signals(bench), *check_guard(bench))
    return [f"Warning: {one.sentence} {one.remedy}" for one in findings if one.fault]


def warn_of_guard(result: Result, bench: Bench) -> Result:
    """Return the result with a warning for every alarm: check, first time, and total duration."""
    if ALARM not in result.columns:
        return result
    times, columns = result.list_rows([ALARM])
    raised, lengths = columns[ALARM], np.diff(times, append=times[-1] + bench.period)
    checks = bench.supervisor.name_checks() if bench.supervisor is not None else {}
    warnings: list[str] = []
    for number in np.unique(raised[raised != 0.0]).tolist():
        first, length = times[raised == number][0], lengths[raised == number].sum()
        names = ", ".join(f"`{name}`" for name in checks.get(int(number) % LIMITED, ["supervisor"]))
        acted = "limited" if number > LIMITED else "cut"
        warnings.append(
            f"Warning: The guard {acted} a signal by {names} (alarm {number:.0f}), first at t = {first:.4g} s, "
            f"for {length:.3g} s in all."
        )
    return replace(result, notes=[*result.notes, *warnings])


def _with_doubts(result: Result, bench: Bench) -> Result:
    warnings: list[str] = []
    for (drive, one), reference in zip(bench.controllers.members().items(), list_references(bench), strict=True):
        names = name_controller_outputs(bench, drive)
        warnings += one.describe_doubts({own: result[name][-1] for own, name in names.items()})
        warnings += describe_expected_miss(result, drive, one.measured, reference)
    return replace(result, notes=[*result.notes, *warnings]) if warnings else result


def warn_of_end(result: Result, duration: float, period: float) -> Result:
    """Return the result with a warning if it does not end at `duration` [s]."""
    end = result.times[-1]
    if result.status.failed or abs(end - duration) <= ROUNDING * duration:
        return result
    warning = (
        f"Warning: The run ends at {end:.6g} s instead of {duration:.6g} s: it goes in periods of {period:.6g} s. "
        "Try a duration that is a multiple of it."
    )
    return replace(result, notes=[*result.notes, warning])


def _with_loops(result: Result, bench: Bench, outside: Mapping[str, AbstractDrive]) -> Result:
    """Return the result with references and wanted signals of drives outside the bench."""
    units = {name: output.unit for name, output in list_readings(bench).items()}
    signals = {drive.name: drive.unit for drive in bench.drives()}
    columns, beside = dict(result.columns), dict(result.beside)
    for drive, name in outside_references(bench, outside).items():
        one, signal = outside[drive], result.waveform[drive].values
        if isinstance(one, AbstractController):
            unit = one.reference_unit(units, signals[drive])
            beside[name] = reference_output(unit, one.measured or drive)
            columns[name] = np.array([one.reference.value(time) for time in result.times.tolist()])
        beside[wanted_name(name)] = wanted_output(signals[drive], drive)
        columns[wanted_name(name)] = np.array([*signal, signal[-1]][: len(result.times)])
    return replace(result, columns=columns, beside=beside)


def reference_waveforms(bench: Bench) -> dict[str, AbstractWaveform]:
    """Return the waveforms of references, references ahead, and manual inputs, by drive."""
    members, hands = bench.controllers.members(), list_hands(bench)
    waveforms = {name: one.reference for name, one in zip(list_references(bench), members.values(), strict=True)}
    waveforms |= {one.name: Ahead(waveform=members[one.drive].reference, lead=one.time) for one in list_previews(bench)}
    for drive, one in members.items():
        if one.manual is not None:
            waveforms |= dict(zip(hands[drive], one.manual.waveforms, strict=True))
    return waveforms


def noise_waveforms(bench: Bench, duration: float, seed: int | None) -> dict[str, AbstractWaveform]:
    """Return standard normal numbers for every sensor of a bench; empty without a seed."""
    if seed is None:
        return {}
    rng = np.random.default_rng(seed)
    count = int(duration / bench.period + 1e-6) + 2
    return {
        name: Held(values=tuple(rng.standard_normal(count).tolist()), frequency=1.0 / bench.period)
        for name in list_noises(bench)
    }


def list_noises(bench: Bench) -> list[str]:
    """Return the drives of a bench for noise and jitter."""
    return [drive.name for drive in list_drive_signals(bench) if drive.name.startswith((NOISE, JITTER))]


def open_loop(bench: Bench, drive: str) -> tuple[Bench, AbstractController]:
    """Return a bench without the controller of a drive, and the controller."""
    members = bench.controllers.members()
    controller = members.pop(drive)
    return bench.with_parts(controllers=Controllers(**members)), controller


class ReadingsOnlyDrive(AbstractDrive):
    """A drive that gets the readings of a bench, not the true outputs."""

    drive: AbstractDrive = part("what answers")

    def init(self) -> Any:
        return self.drive.init()

    def __call__(self, time: float, measurement: Mapping[str, float], memory: Any) -> tuple[float, Any]:
        return self.drive(time, select_visible(measurement), memory)


def select_visible(measurement: Mapping[str, float]) -> dict[str, float]:
    """Return the readings and estimates among the outputs of a bench; all outputs without sensors."""
    readings = {n.removeprefix(MEASURED): v for n, v in measurement.items() if n.startswith(MEASURED)}
    if not readings:
        return dict(measurement)
    ages = {name + AGE: 0.0 for name in readings}
    return ages | readings | {n: v for n, v in measurement.items() if n.startswith(ESTIMATED)}
