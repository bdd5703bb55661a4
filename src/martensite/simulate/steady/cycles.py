r"""Limit cycles, computed by shooting.

For drives of period T, the final state is a function P of the initial state, with an exact Jacobian. The cycle
satisfies P(s) = s. Simulated periods establish memory and branch, and Newton steps then converge. Floquet
multipliers, the eigenvalues of the Jacobian, are the growth factors of small changes per period.

Changes of memory that no period overwrites remain. Such directions have the multiplier 1 and count as neutral,
neither stable nor unstable. A cycle is therefore a member of a family, selected by the initial state.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.assembly.base import JUDGED
from martensite.base.errors import InputError, SolveError
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.api import longest_step
from martensite.simulate.drive_waveforms import Waveforms, arrange_waveforms, grid_of
from martensite.simulate.judgement import Judgement, judge_columns
from martensite.simulate.steady.equilibria import rest_signals
from martensite.simulate.steady.periodic_motion import PeriodGrid, PeriodicMotion, Stability
from martensite.simulate.steady.subjects import Subject

if TYPE_CHECKING:
    from martensite.scenario.scenario import Scenario

LEAD_PERIODS, MOST_PERIODS = 4, 20_000
"""Simulated periods before the first Newton step, and maximum total."""
ROUNDING = 1e-14
"""Newton step that counts as zero, in sizes of the states."""
QUIET = 1e-9
"""Change of a martensite fraction that counts as zero."""
LEAST_STEPS = 200
"""Minimum number of steps in a period."""


@dataclass(frozen=True, eq=False)
class PeriodicOrbit:
    """Periodic motion."""

    system: AbstractSystem
    period: float
    """[s]"""
    times: Numbers
    """Times within the period [s], both ends included."""
    outputs: dict[str, Numbers]
    """At these times, in SI."""
    state: Numbers
    """State variables at the start of the period, flat."""
    stability: Stability
    residual: float
    """Remaining change over a period, as a fraction of the sizes."""
    periods: int
    """Number of simulated periods."""

    @cached_property
    def judgement(self) -> Judgement:
        """Return the limits that the motion exceeds."""
        columns = {name: column.tolist() for name, column in self.outputs.items()}
        return judge_columns(self.system, self.times.tolist(), columns)

    @property
    def stable(self) -> bool:
        """Return whether all changes decay, except neutral ones."""
        return self.stability.stable

    def amplitude(self, name: str) -> float:
        """Return half the range of an output."""
        return 0.5 * float(np.ptp(self.outputs[name]))


def find_cycle(
    subject: Scenario | AbstractSystem,
    waveform: Waveforms | None = None,
    *,
    step: float | None = None,
    state: Numbers | None = None,
) -> PeriodicOrbit:
    """Find the periodic motion of a system under periodic drives.

    Args:
        subject: a scenario, or a system.
        waveform: waveforms of the drives, instead of those in the scenario.
        step: longest step [s]; by default a 200th of the period, or the limit of the mechanism.
        state: initial state; by default equilibrium without signals.

    Raises:
        InputError: the drives have no common period.
        CompileError: no C compiler was found.
        SolveError: the state does not become periodic.
    """
    one = Subject.read(subject, waveform)
    period = find_period(one.waveforms)
    grid = build_period(one.system, one.waveforms, period, step)
    motion = PeriodicMotion(one.system, rest_signals(one.system), [], grid=grid)
    begin = motion.stretch.rest(list(grid.signals[0] * 0.0 + rest_signals(one.system))) if state is None else state
    way = ShootingMethod(motion, np.array(begin, float))
    way.run()
    times, outputs = motion.observe(way.state)
    stability = motion.judge(way.state)
    return PeriodicOrbit(one.system, period, times, outputs, way.state, stability, way.period_change, way.count)


class ShootingMethod:
    """Search for a periodic state by simulated periods and Newton steps.

    Newton steps could skip the start of a transformation. They are therefore used only while all fractions are
    constant from period to period. Their length is limited to small changes of temperature and stress, and a step
    that changes a fraction is reverted. Periods are simulated while transformations continue.
    """

    def __init__(self, motion: PeriodicMotion | Any, begin: Numbers, most: int = MOST_PERIODS) -> None:
        self.most = most
        system = motion.stretch.system
        self.motion, self.state, self.count, self.period_change = motion, begin, 0, math.inf
        remembers = bool(motion.stretch.compiled.points)
        ports = system.actuators() if remembers else {}
        self.fractions = [system.label(port, "martensite_fraction") for port in ports]
        self.leaps = {system.label(port, name): JUDGED[name] for port in ports for name in ("temperature", "stress")}

    def run(self) -> None:
        """Iterate until the state is periodic.

        Raises:
            SolveError: the iteration does not converge.
        """
        self._march(LEAD_PERIODS)
        wait = 1
        while self.count < self.most:
            self.period_change = self.motion.measure_change(self.state)
            self.count += 1
            if self.period_change <= self.motion.settled:
                return
            wait = 1 if self._leap() else min(2 * wait, 64)
            self._march(wait)
        raise SolveError(
            f"The state does not repeat after {self.count} periods: from period to period it still changes by "
            f"{self.period_change:.1e} of its range."
        )

    def _march(self, periods: int) -> None:
        for _ in range(periods):
            self.state = self.motion.go_on(self.state)
        self.count += periods

    def _leap(self) -> bool:
        """Apply a full or limited Newton step; return whether it is accepted."""
        motion, state = self.motion, self.state
        end = motion.march(state)[0][-1]
        before = self._see(state)
        if self._changed(before, self._see(end)):
            return False
        linear = motion.linearise(state)
        change: Numbers = (
            np.linalg.lstsq(linear.jacobian * linear.sizes, -linear.residual, rcond=1e-10)[0] * linear.sizes
        )
        change[np.abs(change) <= ROUNDING * linear.sizes] = 0.0
        there = self._see(state + change)
        reach = [abs(there[name] - before[name]) / most for name, most in self.leaps.items()]
        trial = state + change / max(1.0, *reach, 1.0)
        try:
            left = motion.measure_change(trial)
        except SolveError:
            return False
        self.count += 1
        if not left < self.period_change or self._changed(before, self._see(motion.march(trial)[0][-1])):
            return False
        self.state = trial
        return True

    def _see(self, state: Numbers) -> dict[str, float]:
        signals = self.motion.signals_at_begin()
        return {name: float(one[0]) for name, one in self.motion.stretch.observe(state[None], signals[None]).items()}

    def _changed(self, before: Mapping[str, float], after: Mapping[str, float]) -> bool:
        """Return whether a fraction has changed."""
        return any(abs(after[name] - before[name]) > QUIET for name in self.fractions)


def find_period(waveforms: Mapping[str, AbstractWaveform]) -> float:
    """Return the common period of all drives [s].

    Raises:
        InputError: a drive has no period, or periods differ.
    """
    periods = dict[str, float]()
    for name, one in waveforms.items():
        if isinstance(one, Constant):
            continue
        numbers = {leaf.path: float(leaf.value) for leaf in one.leaves()}
        if "frequency" in numbers and numbers["frequency"] > 0.0:
            periods[name] = 1.0 / numbers["frequency"]
        elif "period" in numbers:
            periods[name] = numbers["period"]
        else:
            raise InputError(
                f"The drive `{name}` (`{one.registered_name}`) has no period; a cycle needs drives that repeat "
                "themselves, such as `pwm` or `sine`."
            )
    if not periods:
        raise InputError(
            "All drives are constant, so they have no period; compute the steady state or the rotation instead."
        )
    longest = max(periods.values())
    for name, one in periods.items():
        if abs(longest / one - round(longest / one)) > 1e-9:
            raise InputError(
                f"The drives have no common period: the period of `{name}` is {one:.6g} s, another {longest:.6g} s."
            )
    return longest


def build_period(
    system: AbstractSystem, waveforms: Mapping[str, AbstractWaveform], period: float, step: float | None
) -> PeriodGrid:
    """Return the steps of the second period, since the first can differ.

    Raises:
        InputError: a waveform does not repeat in the period.
    """
    longest = step or min(period / LEAST_STEPS, longest_step(system))
    rows = list[Numbers]()
    grids = [grid_of(system, dict(waveforms), count * period, count + 1, longest) for count in (1, 2)]
    for grid in grids:
        rows.append(np.column_stack([np.asarray(grid.drives, float), np.asarray(grid.lengths)]))
    first, both = rows
    second = both[len(first) :]
    if len(both) != 2 * len(first) or not np.allclose(first, second, rtol=1e-6, atol=1e-9 * np.abs(first).max()):
        raise InputError(f"The drives do not repeat after {period:.6g} s.")
    times = np.concatenate([[0.0], np.cumsum(first[:, -1])])
    signals = _read_signals(system, waveforms, times)
    return PeriodGrid(np.ascontiguousarray(first), times, signals)


def _read_signals(system: AbstractSystem, waveforms: Mapping[str, AbstractWaveform], times: Numbers) -> Numbers:
    """Return all drives at some times, (times, drives)."""
    waves = arrange_waveforms(system, dict(waveforms))
    return np.array([one.signals(times.tolist()) for one in waves]).T.reshape(len(times), len(waves))
