"""Heating against cooling: how fast an output goes up and down again after steps of the signal.

    rise, fall              time from the step until 90 % of the way is gone
    fastest up and down     largest |dy/dt|, over one step of the run

Heating is as fast as there is power for it; cooling is left to the surroundings. So the two differ,
and each in its own way with signal and load.
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
"""Share of the way that is gone in the time of a rise."""
SAMPLES = 400
"""Steps in which a level is held, at least."""


@dataclass(frozen=True, eq=False)
class Speeds:
    """Speeds of up and down steps; arrays of shape (loads, signals)."""

    drive: str
    output: str
    units: tuple[str, str]
    """SI units of drive and output."""
    signals: Numbers
    """Upper levels, shape (signals,)."""
    load: str
    """Path of the parameter that is the load; empty without."""
    loads: Numbers
    """Values of the load, shape (loads,); one NaN without a load."""
    stroke: Numbers
    """Travel of the output up to the end of the upper level."""
    rise: Numbers
    """[s]"""
    fall: Numbers
    """[s]; infinite where the output does not come back within the time."""
    fastest_up: Numbers
    """Largest rate after the step up [unit/s]."""
    fastest_down: Numbers
    """Largest rate after the step down [unit/s]."""
    times: Numbers
    """From the step up on [s], shape (samples,)."""
    courses: Numbers
    """The output, shape (loads, signals, samples)."""
    hold: float
    """When the signal steps down [s]."""

    @property
    def ratio(self) -> Numbers:
        """Fall over rise."""
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
    """Return the steps up and down again, all signals and loads side by side.

    Args:
        system: a plant, or a bench; of one with a controller the drive is `reference`.
        signals: levels of the step up, in the unit of the drive.
        hold: how long they are held [s].
        low: level before and after.
        back: for how long it is followed afterwards [s]; as long as `hold` if not given.
        load: path, or unique ending of one, of a parameter that is varied too.
        loads: its values, in SI.
        drive: which one; the first if not named.
        output: which one; the first coordinate of the mechanism if not named.
        native: whether to run in C; by default if there is a compiler.

    Raises:
        InputError: a name does not fit, a number is not above 0, or loads have no name.
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
    """Return the output from the step up on, shape (samples, lanes), and the sample of the step down."""
    up, down = (max(round(time / dt), 1) for time in lasting)
    first = lanes.reset(low)
    extra = 1 if lanes.interval else 0
    played = np.full((up + down + extra, lanes.count), low)
    played[:up] = levels
    return np.concatenate([first[None], lanes.run(played, dt)]), up


def _find_rise_time(rows: Numbers, dt: float) -> Numbers:
    """Return the time until 90 % of the way to the last row are gone [s], read between samples."""
    way = rows[-1] - rows[0]
    safe = np.where(way == 0.0, 1.0, way)
    gone = (rows - rows[0]) / safe
    found = np.full(rows.shape[1], np.inf)
    for lane, course in enumerate(gone.T):
        reached = np.flatnonzero(course >= RISE)
        if way[lane] != 0.0 and len(reached):
            k = int(reached[0])
            share = (RISE - course[k - 1]) / (course[k] - course[k - 1])
            found[lane] = dt * (k - 1 + share)
    return found
