"""What the example of a C core plays: the drive of a run, or the readings of a loop in one."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import accumulate
from typing import Any

from martensite.actuators.assembly import AbstractSystem
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import MEASURED, list_references
from martensite.control.loop.realtime import list_reads
from martensite.control.loop.run import reference_waveforms
from martensite.export.c_example import Step
from martensite.signals.base import AbstractWaveform
from martensite.simulate.api import first_step
from martensite.simulate.compiled import compile_march
from martensite.simulate.drive_waveforms import Waveforms, by_name, grid_of
from martensite.simulate.result import Result

Played = tuple[tuple[float, ...], list[Step]]
"""Inputs at the start, and the steps."""
MOST = 5
"""Times as many steps as wanted, at most."""


def played_by_system(
    system: AbstractSystem, waveform: Waveforms | Mapping[str, Any], duration: float, steps: int
) -> Played:
    """The drive of a run of a system, or of a bench without noise, in so many steps or more.

    None is longer than what a run begins with, and those of a system in discrete time are its
    samples. A run of more than `MOST` times as many is not played to its end.
    """
    waveforms: Mapping[str, AbstractWaveform]
    if isinstance(system, Bench):
        waveforms = {**by_name(system.plant, waveform), **reference_waveforms(system)}
    else:
        waveforms = by_name(system, waveform)
    step = system.sample_time() or min(first_step(system, duration, 2), duration / steps)
    grid = grid_of(system, waveforms, min(duration, MOST * steps * step), 2, step)
    starts = list(accumulate(compile_march(system).widths, initial=0))[:-1]
    rows = (tuple(row[k] for k in starts) for row in grid.drives)  # the mean comes first
    return grid.sampled[0], list(zip(grid.lengths, rows, strict=True))


def played_by_loop(bench: Bench, waveform: Waveforms, result: Result, steps: int) -> Played:
    """Readings, ages, references and free signals of a run on the bench, sample by sample.

    At most `MOST` times so many samples.
    """
    sensors, taken = bench.sensors.members(), bench.controllers.members()
    measured = [(MEASURED if sensors else "") + name for name in list_reads(bench)]
    ages = [sensors[name].delay if name in sensors else 0.0 for name in list_reads(bench)]
    given = by_name(bench.plant, waveform)
    free = [given.get(d.name) for d in bench.plant.drives() if d.name not in taken]
    count = min(len(result.times), MOST * steps + 1)
    rows = [
        (
            *(result.columns[name][k] for name in measured),
            *ages,
            *(result.columns[name][k] for name in list_references(bench)),
            *(one.value(result.times[k]) if one else 0.0 for one in free),
        )
        for k in range(count)
    ]
    return rows[0], [(bench.period, row) for row in rows[1:]]
