"""Loops of a figure of a bench, and the related columns of a result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.base.errors import InputError
from martensite.control.controllers.base import AbstractController
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import ALARM, MEASURED, list_references, outside_references, wanted_name
from martensite.control.observers.base import ESTIMATED
from martensite.show.figures.labels import describe_axis
from martensite.simulate.result import Result

TEMPERATURE = "temperature"


@dataclass(frozen=True)
class Loop:
    """Columns of a controller's loop."""

    drive: str
    reference: Any
    """Reference of the reading over the times of the result [SI]."""
    reading: str
    truth: str
    """Column of the measured quantity, else of the reading."""
    requested_signal: str
    """Column of the requested signal; empty without one."""


def find_bench(result: Result) -> Bench:
    """Return the bench of a result."""
    if not isinstance(result.system, Bench):
        raise InputError("This figure needs a bench; use `plot_result` for a system without controllers and sensors.")
    return result.system


def find_loops(result: Result, outside: Mapping[str, AbstractController] | None = None) -> list[Loop]:
    """Return the loops of a bench, including controllers outside of it, given by drive."""
    bench = find_bench(result)
    members = bench.controllers.members()
    entries = [
        _find_loop(result, bench, drive, one, name)
        for (drive, one), name in zip(members.items(), list_references(bench), strict=True)
    ]
    outer = outside or {}
    for drive, name in outside_references(bench, outer).items():
        entries.append(_find_loop(result, bench, drive, outer[drive], name))
    return [loop for loop in entries if loop is not None]


def _find_loop(result: Result, bench: Bench, drive: str, one: AbstractController, name: str) -> Loop | None:
    reading = _find_column(result, one.measured)
    if reading is None:
        return None
    truth = _find_truth(result, bench, one.measured, reading)
    recorded = name in result.columns  # only runs of `simulate_bench` have it
    given = result.columns[name] if recorded else [one.reference.value(time) for time in result.times]
    wanted = wanted_name(name) if recorded else ""
    return Loop(drive, np.asarray(given, dtype=np.float64), reading, truth, wanted)


def _find_column(result: Result, name: str) -> str | None:
    return next((c for c in (MEASURED + name, name) if c in result.outputs), None)


def _find_truth(result: Result, bench: Bench, name: str, reading: str) -> str:
    sensor = bench.sensors.members().get(name)
    truth = sensor.sees()[0] if sensor is not None else name.removeprefix(ESTIMATED)
    comparable = truth in result.outputs and result.unit(truth) == result.unit(reading)
    return truth if comparable else reading


def map_applied_signals(result: Result) -> dict[str, str]:
    """Return the column of the source signal by drive of the plant."""
    plant = find_bench(result).plant
    return {plant.drive_at(port): plant.label(port, "drive") for port in plant.actuators()}


def list_temperatures(result: Result) -> list[str]:
    """Return the columns of the temperatures of all elements."""
    plant = find_bench(result).plant
    return [plant.label(port, TEMPERATURE) for port in plant.actuators()]


def list_estimates(result: Result, loops: Sequence[Loop]) -> list[str]:
    """Return the columns of estimates with a known truth that no loop shows."""
    readings = {loop.reading for loop in loops}
    return [
        name
        for name in result.columns
        if name.startswith(ESTIMATED) and name not in readings and name.removeprefix(ESTIMATED) in result.columns
    ]


def find_alarmed_spans(result: Result) -> list[tuple[float, float]]:
    """Return the time intervals of supervisor alarms [s]."""
    if ALARM not in result.columns:
        return []
    times, columns = result.list_rows([ALARM])
    raised = columns[ALARM] > 0.5
    spans: list[tuple[float, float]] = []
    begin: float | None = None
    for time, on in zip(times.tolist(), raised.tolist(), strict=True):
        if on and begin is None:
            begin = time
        if not on and begin is not None:
            spans.append((begin, time))
            begin = None
    return spans if begin is None else [*spans, (begin, result.times[-1])]


def compute_shown_error(result: Result, loop: Loop) -> Any:
    """Return reference minus truth, in the displayed unit of the truth."""
    how = describe_axis(result, loop.truth)
    return how.values(loop.reference) - how.values(result.columns[loop.truth])
