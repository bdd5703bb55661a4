"""Runs that are tried: to where a scenario can lead at most, and to the step that it needs.

A system comes to rest under drives that are held: every drive goes from its first level to the lowest,
or the highest, of its waveform and is held there until nothing changes. A scenario whose drives stay
there long enough ends there; one of short pulses does not, which only its run can tell.

Fits and exported models run on equal steps: those do not change with the parameters, so that what is
computed on them is as smooth as the model is, and differentiates exactly. They are halved until a run
on them agrees with one that has an error control.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import SolveError
from martensite.base.status import Status
from martensite.signals.table import Table
from martensite.simulate.api import first_step, longest_step, simulate
from martensite.simulate.drive_waveforms import Waveforms, by_name
from martensite.simulate.result import Result

LONG = 200.0
"""Longest sensible steps for which drives are held: twenty thermal time constants."""
ROUGH = 1e-2
"""Tolerance of a run to rest."""
TRIED = 5.0
"""CPU time [s] for which a run is tried."""
HALVINGS = 12
HALVED = 0.5


@dataclass(frozen=True)
class EndState:
    """What drives that are held lead to."""

    levels: dict[str, float]
    """Level of every drive, in the unit of its source."""
    result: Result
    """The run to rest; it ends where it leaves the envelope."""

    @property
    def leaves(self) -> bool:
        """Whether it is outside of the envelope."""
        return self.result.status is Status.OUT_OF_ENVELOPE


def find_end_states(system: AbstractSystem, waveform: Waveforms, duration: float) -> list[EndState]:
    """States of rest with all drives at their lowest levels, and with all at their highest; what cools the other way.

    None for a system in discrete time, whose drives are set by controllers.

    Raises:
        SolveError: a run to rest fails.
    """
    if system.sample_time() or not system.drives():
        return []
    waves = by_name(system, waveform)
    shapes = {name: one.moments(0.0, duration) for name, one in waves.items()}
    first = {name: one.value(0.0) for name, one in waves.items()}
    lowest = {name: shape.low for name, shape in shapes.items()}
    highest = {name: shape.high for name, shape in shapes.items()}
    held = LONG * min(longest_step(system), duration)
    cools = {name for one in system.actuators().values() for name in one.environment.cooling.signals()} & set(shapes)
    for name in cools:
        lowest[name], highest[name] = highest[name], lowest[name]
    rows = [lowest] if lowest == highest else [lowest, highest]
    return [_end_state(system, first, levels, held) for levels in rows]


def _end_state(system: AbstractSystem, first: Mapping[str, float], levels: dict[str, float], time: float) -> EndState:
    waves = {
        name: Table(times=(0.0, 0.1 * time, time), values=(first[name], level, level)) for name, level in levels.items()
    }
    return EndState(levels, simulate(system, waves, time, tolerance=ROUGH, samples=51))


def leaves_envelope(system: AbstractSystem, waveform: Waveforms, duration: float) -> str:
    """The sentence of a run that leaves the envelope; empty if it stays, or is too long to try."""
    try:
        result = simulate(system, waveform, duration, tolerance=ROUGH, samples=51, budget=TRIED)
    except SolveError:
        return ""
    return result.warnings[0] if result.status is Status.OUT_OF_ENVELOPE else ""


class EqualStep(NamedTuple):
    """A longest step, and what a run on it is off by."""

    step: float
    """[s]"""
    apart: float
    """Largest difference of what is judged, as a share of its range."""


def find_step(
    system: AbstractSystem, waveform: Waveforms, duration: float, tolerance: float, samples: int = 1001
) -> EqualStep:
    """The longest step [s] of a row of halved ones with which a run is within a tolerance, as a share of range.

    Raises:
        SolveError: the run fails.
    """
    meant = simulate(system, waveform, duration, tolerance=HALVED * tolerance, samples=samples)
    step, apart = first_step(system, duration, 2), math.inf
    for _ in range(HALVINGS):
        found = simulate(system, waveform, duration, step=step, samples=samples)
        apart = _compare_runs(system, found, meant)
        if apart <= tolerance:
            break
        step *= HALVED
    return EqualStep(step, apart)


def _compare_runs(system: AbstractSystem, found: Result, meant: Result) -> float:
    """Largest difference of what is judged, as a share of its range."""
    shares: list[float] = []
    for name, least in system.convergence_scales().items():
        pairs = zip(found.columns[name], meant.columns[name], strict=False)
        shares.append(max(abs(a - b) for a, b in pairs) / max(meant.range(name), least))
    return max(shares, default=0.0)
