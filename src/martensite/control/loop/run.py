"""`simulate_bench`: one run of a bench, with its noise drawn and its references played.

References come from the controllers themselves, noise from a seed. A user-defined drive may run outside the kernel: it
is called once per period with the readings of the bench. The result has the columns `reference` and `wanted` of
either.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base.errors import InputError
from martensite.base.parameters import part
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
    list_drives,
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
from martensite.simulate.restarts import HOME, Restart

if TYPE_CHECKING:
    from martensite.simulate.result import Result

ROUNDING = 1e-6
"""Share of a duration by which a run may end at another time."""


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
    """Run a bench, by default from rest.

    Args:
        bench: plant, sensors, observers, controllers, supervisor and faults.
        duration: end of the run [s], counted from 0, at least a period; a warning reports another end
            if this is not a whole number of periods.
        outside: drives that run outside of the kernel, by name of the driven signal, called once per period.
        waveforms: signals of plant drives without a controller, by drive; a drive that is not named gets 0.
        seed: seed of noise and jitter; None for a run without them. The result keeps it as `seed`.
        runtime: floats or c; by default c if there is a compiler.
        budget: CPU time [s] after which the run is given up; not if something runs outside.
        watch: called after every period with the share of the run that is done, if something runs outside.
        start: state kept by a result, from which the run continues.
        restart_at: samples [s] at which a state is kept; not if something runs outside.

    Raises:
        InputError: a name or a unit does not fit.
        SolveError: the run failed; the sentence says when and what to try.
    """
    played: dict[str, Any] = {**(waveforms or {}), **reference_waveforms(bench)}
    played |= (noise := noise_waveforms(bench, duration, seed))
    drawn = seed if noise else None
    if outside:
        if budget is not None:
            raise InputError("A run whose controllers run outside has no budget.")
        if start is not HOME or restart_at:
            raise InputError("A run whose controllers run outside keeps no states: there is nothing to go on from.")
        seeing = {name: Seeing(drive=drive) for name, drive in outside.items()}
        periods = round(duration / bench.period)
        length = periods * bench.period
        found = simulate_controlled(bench, played | seeing, length, bench.period, watch=watch)
        return warn_of_loops(replace(_with_loops(found, bench, outside), seed=drawn), bench, duration)
    chosen = runtime or ("c" if find_compiler() is not None else "floats")
    samples = int(duration / bench.period + 1e-6) + 1
    found = simulate(
        bench,
        played,
        duration,
        samples=max(samples, 2),
        runtime=chosen,
        budget=budget,
        start=start,
        restart_at=restart_at,
    )
    return warn_of_loops(replace(found, seed=drawn), bench, duration)


def warn_of_loops(result: Result, bench: Bench, duration: float) -> Result:
    """Add actions of the guard, failures of controllers, impossible signals, and the end [s] to a result."""
    faults = [
        f"Warning: {one.sentence} {one.remedy}" for one in (*check_signals(bench), *check_guard(bench)) if one.fault
    ]
    known = _with_doubts(warn_of_guard(result, bench), bench)
    return warn_of_end(replace(known, notes=[*known.notes, *faults]), duration, bench.period)


def warn_of_guard(result: Result, bench: Bench) -> Result:
    """Return the result with a warning for every alarm of the supervisor: which check, when first, for how long."""
    if ALARM not in result.columns:
        return result
    times, columns = result.list_rows([ALARM])
    raised, lengths = columns[ALARM], np.diff(times, append=times[-1] + bench.period)
    checks = bench.supervisor.name_checks() if bench.supervisor is not None else {}
    said: list[str] = []
    for number in np.unique(raised[raised != 0.0]).tolist():
        first, length = times[raised == number][0], lengths[raised == number].sum()
        names = ", ".join(f"`{name}`" for name in checks.get(int(number) % LIMITED, ["supervisor"]))
        acted = "limited" if number > LIMITED else "cut"
        said.append(
            f"Warning: The guard {acted} a signal by {names} (alarm {number:.0f}), first at t = {first:.4g} s, "
            f"for {length:.3g} s in all."
        )
    return replace(result, notes=[*result.notes, *said])


def _with_doubts(result: Result, bench: Bench) -> Result:
    """Return a result with what controllers failed to do."""
    said: list[str] = []
    for (drive, one), reference in zip(bench.controllers.members().items(), list_references(bench), strict=True):
        names = name_controller_outputs(bench, drive)
        said += one.describe_doubts({own: result[name][-1] for own, name in names.items()})
        said += describe_expected_miss(result, drive, one.measured, reference)
    return replace(result, notes=[*result.notes, *said]) if said else result


def warn_of_end(result: Result, duration: float, period: float) -> Result:
    """Return the result in periods [s], with a warning if it ends at another time [s] than was asked for."""
    end = result.times[-1]
    if result.status.failed or abs(end - duration) <= ROUNDING * duration:
        return result
    said = (
        f"Warning: The run ends at {end:.6g} s instead of {duration:.6g} s: it goes in periods of {period:.6g} s. "
        "Try a duration that is a multiple of it."
    )
    return replace(result, notes=[*result.notes, said])


def _with_loops(result: Result, bench: Bench, outside: Mapping[str, AbstractDrive]) -> Result:
    """Return a result with the references, and the wanted signals, of drives outside of the bench.

    Nobody answers at the end: the last signal is held.
    """
    units = {name: output.unit for name, output in list_readings(bench).items()}
    signals = {drive.name: drive.unit for drive in bench.drives()}
    columns, beside = dict(result.columns), dict(result.beside)
    for drive, name in outside_references(bench, outside).items():
        one, held = outside[drive], result.waveform[drive].values
        if isinstance(one, AbstractController):
            unit = one.reference_unit(units, signals[drive])
            beside[name] = reference_output(unit, one.measured or drive)
            columns[name] = np.array([one.reference.value(time) for time in result.times.tolist()])
        beside[wanted_name(name)] = wanted_output(signals[drive], drive)
        columns[wanted_name(name)] = np.array([*held, held[-1]][: len(result.times)])
    return replace(result, columns=columns, beside=beside)


def reference_waveforms(bench: Bench) -> dict[str, AbstractWaveform]:
    """Return the waveforms of references, of references ahead, and of manual inputs, by name of drive."""
    members, hands = bench.controllers.members(), list_hands(bench)
    found = {name: one.reference for name, one in zip(list_references(bench), members.values(), strict=True)}
    found |= {one.name: Ahead(waveform=members[one.drive].reference, lead=one.time) for one in list_previews(bench)}
    for drive, one in members.items():
        if one.manual is not None:
            found |= dict(zip(hands[drive], one.manual.waveforms, strict=True))
    return found


def noise_waveforms(bench: Bench, duration: float, seed: int | None) -> dict[str, AbstractWaveform]:
    """Return the standard normal numbers for every sensor of a bench; none without a seed."""
    if seed is None:
        return {}
    rng = np.random.default_rng(seed)
    count = int(duration / bench.period + 1e-6) + 2
    return {
        name: Held(values=tuple(rng.standard_normal(count).tolist()), frequency=1.0 / bench.period)
        for name in list_noises(bench)
    }


def list_noises(bench: Bench) -> list[str]:
    """Return the names of the drives of a bench that play noise or jitter."""
    return [drive.name for drive in list_drives(bench) if drive.name.startswith((NOISE, JITTER))]


def open_loop(bench: Bench, drive: str) -> tuple[Bench, AbstractController]:
    """Return a bench without the controller of a drive, and that controller."""
    members = bench.controllers.members()
    controller = members.pop(drive)
    return bench.with_parts(controllers=Controllers(**members)), controller


class Seeing(AbstractDrive):
    """A drive that sees of a bench what a controller may see: readings, not the truth."""

    drive: AbstractDrive = part("what answers")

    def init(self) -> Any:
        """Return the memory of the drive."""
        return self.drive.init()

    def __call__(self, time: float, measurement: Mapping[str, float], memory: Any) -> tuple[float, Any]:
        """Return its signal at `time` [s] and its new memory."""
        return self.drive(time, select_visible(measurement), memory)


def select_visible(measurement: Mapping[str, float]) -> dict[str, float]:
    """Return the readings and estimates among the outputs of a bench; without any, all of them."""
    found = {n.removeprefix(MEASURED): v for n, v in measurement.items() if n.startswith(MEASURED)}
    if not found:
        return dict(measurement)
    ages = {name + AGE: 0.0 for name in found}
    return ages | found | {n: v for n, v in measurement.items() if n.startswith(ESTIMATED)}
