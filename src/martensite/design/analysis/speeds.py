"""Rise and fall of an output after steps of the signal.

    rise, fall              time from the step to 90 % of the change
    fastest up and down     largest |dy/dt| over one step of the run

Heating is limited by the power, cooling by the surroundings, so the two speeds differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError
from martensite.design.sweep.driven_lanes import DrivenLanes, require_positive
from martensite.signals.sampling.sampled import Numbers

RISE = 0.90
"""Fraction of the change at the end of a rise."""
SAMPLES = 400
"""Smallest number of steps of a level."""


@dataclass(frozen=True, eq=False)
class Speeds:
    """Speeds after up and down steps, in arrays of shape (loads, signals)."""

    drive: str
    output: str
    units: tuple[str, str]
    """SI units of drive and output."""
    signals: Numbers
    """Upper levels, shape (signals,)."""
    load: str
    """Path of the varied load; empty without one."""
    loads: Numbers
    """Values of the load, shape (loads,); NaN without a load."""
    stroke: Numbers
    """Change of the output at the end of the upper level."""
    rise: Numbers
    """[s]"""
    fall: Numbers
    """[s]; infinite if the output does not return in time."""
    fastest_up: Numbers
    """Largest rate after the step up [unit/s]."""
    fastest_down: Numbers
    """Largest rate after the step down [unit/s]."""
    times: Numbers
    """Time after the step up [s], shape (samples,)."""
    courses: Numbers
    """Output, shape (loads, signals, samples)."""
    hold: float
    """Time of the step down [s]."""

    @property
    def ratio(self) -> Numbers:
        """Return the fall time over the rise time."""
        return self.fall / self.rise


def compute_speeds(
    system: AbstractSystem,
    signals: Sequence[float] | Numbers,
    hold: float,
    *,
    low: float = 0.0,
    back: float | None = None,
    load: str | None = None,
    loads: Sequence[float] | Numbers = (),
    drive: str | None = None,
    output: str | None = None,
    native: bool | None = None,
) -> Speeds:
    """Return the speeds after steps up and down, for all signals and loads.

    Args:
        system: a plant, or a bench; a closed loop has the drive `reference`.
        signals: levels of the step up, in the unit of the drive.
        hold: duration of a level [s].
        low: level before and after.
        back: duration after the step down [s], by default `hold`.
        load: path, or unique ending, of a varied parameter.
        loads: its values, in SI.
        drive: driven signal, by default the first.
        output: evaluated output, by default the first coordinate of the mechanism.
        native: run in C, by default if there is a compiler.

    Raises:
        InputError: a name is unknown, a number is not above 0, or loads have no name.
        ParameterError: the parameter does not exist.
        SolveError: a run failed.
    """
    require_positive("hold", hold, "s")
    after = hold if back is None else float(require_positive("back", back, "s")[0])
    levels = np.atleast_1d(np.asarray(signals, float))
    if not levels.size or bool(load) != bool(len(loads)):
        raise InputError("Give the signals; for a load, give both its name and its values.")
    path = system.resolve(load) if load else ""
    values = np.atleast_1d(np.asarray(loads, float)) if load else np.array([np.nan])
    shape = len(values), len(levels)
    given = {path: np.repeat(values, len(levels))} if load else None
    lanes = DrivenLanes(system, values.size * levels.size, drive, output, given, native)
    dt = lanes.step(min(hold, after) / SAMPLES)
    rows, up = _step_response(lanes, np.tile(levels, len(values)), low, (hold, after), dt)
    outputs, drives = system.outputs(), {one.name: one.unit for one in system.drives()}
    units = drives[lanes.drive], outputs[lanes.output].unit
    rise, fall = _find_rise_time(rows[: up + 1], dt), _find_rise_time(rows[up:], dt)
    rates = np.abs(np.diff(rows, axis=0)) / dt
    fastest = rates[:up].max(axis=0), rates[up:].max(axis=0)
    return Speeds(
        lanes.drive,
        lanes.output,
        units,
        levels,
        path,
        values,
        (rows[up] - rows[0]).reshape(shape),
        rise.reshape(shape),
        fall.reshape(shape),
        fastest[0].reshape(shape),
        fastest[1].reshape(shape),
        dt * np.arange(len(rows)),
        rows.T.reshape(*shape, -1),
        up * dt,
    )


def _step_response(
    lanes: DrivenLanes, levels: Numbers, low: float, lasting: tuple[float, float], dt: float
) -> tuple[Numbers, int]:
    """Return the output after the step up, shape (samples, lanes), and the sample of the step down."""
    up, down = (max(round(time / dt), 1) for time in lasting)
    first = lanes.reset(low)
    extra = 1 if lanes.interval else 0
    played = np.full((up + down + extra, lanes.count), low)
    played[:up] = levels
    return np.concatenate([first[None], lanes.run(played, dt)]), up


def _find_rise_time(rows: Numbers, dt: float) -> Numbers:
    """Return the interpolated time to 90 % of the change to the last row [s]."""
    way = rows[-1] - rows[0]
    safe = np.where(way == 0.0, 1.0, way)
    progress = (rows - rows[0]) / safe
    times = np.full(rows.shape[1], np.inf)
    for lane, course in enumerate(progress.T):
        reached = np.flatnonzero(course >= RISE)
        if way[lane] != 0.0 and len(reached):
            k = int(reached[0])
            share = (RISE - course[k - 1]) / (course[k] - course[k - 1])
            times[lane] = dt * (k - 1 + share)
    return times
