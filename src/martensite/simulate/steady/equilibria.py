r"""Equilibria under constant drives, and their stability.

With hysteresis, the equilibrium depends on history. Three starts are available:

cold       equilibrium without signals (at ambient temperature), before the signals are applied
hot        equilibrium under the highest signals, before they decrease to the given signals
a state    previous equilibrium, from which the signals change

The system is simulated until all judged outputs are constant. Unstable equilibria are therefore not found, and
oscillations of a dynamic mechanism affect its elements.

Stability follows from the exact Jacobian of a step. Its eigenvalues μ give the growth rates ln μ/Δt. At the limit
of a transformation, the derivative is one-sided, from the direction of approach.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError, SolveError, require_known
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.api import longest_step
from martensite.simulate.judgement import Judgement, judge_state
from martensite.simulate.lanes import Lanes
from martensite.simulate.operating_point import settle_lanes
from martensite.simulate.steady.periodic_motion import Stability, index_drives, judge_stability
from martensite.simulate.steady.stretch import Stretch
from martensite.simulate.steady.subjects import Subject

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario

STARTS = ("cold", "hot")


@dataclass(frozen=True, eq=False)
class SteadyState:
    """Steady state under constant drives."""

    system: AbstractSystem
    signals: dict[str, float]
    """Signals of all drives, in SI."""
    start: str
    """Start of the search: `cold`, `hot` or `state`."""
    outputs: dict[str, float]
    """In SI."""
    state: Numbers
    """All state variables, flat."""
    stability: Stability
    """Stability over one step."""
    step: float
    """Length of the step [s]."""
    before: dict[str, float]
    """Outputs of the initial state, in SI."""

    @cached_property
    def judgement(self) -> Judgement:
        """Return the limits that the state exceeds."""
        return judge_state(self.system, self.outputs, self.before)

    @property
    def stable(self) -> bool:
        """Return whether all changes decay, except neutral ones."""
        return self.stability.stable

    @property
    def time_constant(self) -> float:
        """Return the longest time constant of decay [s]: 0 if below a step, infinite for growth."""
        largest = self.stability.largest
        if largest >= 1.0:
            return np.inf
        return -self.step / float(np.log(largest)) if largest > 1e-3 else 0.0


def find_steady_state(
    subject: Scenario | AbstractSystem,
    drive: Mapping[str, float] | float | None = None,
    *,
    start: str | SteadyState = "cold",
    high: Mapping[str, float] | float | None = None,
) -> SteadyState:
    """Find the steady state of a system under constant drives.

    Args:
        subject: a scenario, or a system.
        drive: level of the first drive, or levels by name, in SI; optional for constant drives of the scenario.
        start: `cold`, `hot`, or an equilibrium from which the drives change.
        high: previous drive levels for `hot`; by default the highest levels of the scenario.

    Raises:
        InputError: a drive is unknown or not given, or `high` is missing.
        CompileError: no C compiler was found.
        SolveError: the system vibrates or rotates instead of settling.
    """
    one = Subject.read(subject)
    signals = one.hold(drive)
    if isinstance(start, SteadyState):
        return _judge_rest(
            one.system, settle_system(one.system, [signals], start.state), signals, "state", start.outputs
        )
    require_known("start", start, STARTS)
    before = [one.hold(_choose_high(one, high))] if start == "hot" else []
    return _judge_rest(one.system, settle_system(one.system, [*before, signals]), signals, start)


def _choose_high(one: Subject, high: Mapping[str, float] | float | None) -> Mapping[str, float] | float:
    """Return the drives of the previous steady state."""
    if high is not None:
        return high
    if one.scenario is None or not np.isfinite(one.scenario.duration):
        raise InputError("The start `hot` needs `high`, the drive under which the system was in steady state before.")
    return one.highest(one.scenario.duration)


def settle_system(system: AbstractSystem, course: list[Numbers], state: Numbers | None = None) -> Numbers:
    """Hold several signals in sequence until each settles, by default from equilibrium.

    Raises:
        SolveError: the system does not settle.
    """
    lanes = Lanes(system, 1, soon=True)
    lanes.reset(rest_signals(system)[:, None])
    if state is not None:
        lanes.state = np.array(state)[:, None]
    for signals in course:
        settle_lanes(lanes, signals[:, None])
    failed = lanes.status[0]
    if failed.failed:
        raise SolveError(f"The system failed before its steady state. {failed.sentence}")
    return lanes.state[:, 0].copy()


def rest_signals(system: AbstractSystem) -> Numbers:
    """Return zero signals; ambient temperature for a drive that prescribes a temperature."""
    ambient = {system.drive_at(port): one.environment.temperature for port, one in system.actuators().items()}
    return index_drives(system, {one.name: ambient[one.name] for one in system.drives() if one.unit == "K"})


def _judge_rest(
    system: AbstractSystem, state: Numbers, signals: Numbers, start: str, before: dict[str, float] | None = None
) -> SteadyState:
    """Return an equilibrium with outputs, stability and previous outputs, by default without drives."""
    stretch, dt = Stretch(system), longest_step(system)
    row, _ = stretch.hold(signals)
    given, n = np.append(row, dt)[None], stretch.size
    end = stretch.march(state, given, np.eye(n), np.zeros((*given.shape, n)), np.zeros((0, n)))
    home = rest_signals(system)
    if before is None:
        before = _first_row(stretch.observe(stretch.rest(list(home))[None], home[None]))
    names = [one.name for one in system.drives()]
    return SteadyState(
        system,
        dict(zip(names, map(float, signals), strict=True)),
        start,
        _first_row(stretch.observe(state[None], signals[None])),
        state,
        judge_stability(end.slopes),
        dt,
        before,
    )


def _first_row(columns: dict[str, Numbers]) -> dict[str, float]:
    """Return the first value of every column."""
    return {name: float(column[0]) for name, column in columns.items()}
