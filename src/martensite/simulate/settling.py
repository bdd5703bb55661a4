"""Search for the start of a run by simulation: an equilibrium or a closed cycle.

`equilibrium` is the steady state under the first values of the drives. `settled cycle` is the start of a drive
period that ends in its initial state.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.simulate.api import longest_step, simulate
from martensite.simulate.drive_waveforms import Waveforms, by_name
from martensite.simulate.restarts import AT, EQUILIBRIUM, HOME, PERIOD, WHERE, Restart
from martensite.simulate.result import Result
from martensite.simulate.steady.cycles import find_period

MOST_CYCLES, MOST_RESTS = 300, 9
"""Maximum number of periods, and of stretches of doubling length."""
RESTLESS = 4
"""Stretches after which changes must have fallen by half."""
REST = 200.0
"""Length of the first stretch, in initial steps of a run."""
LOOKED = 65
"""Samples of a stretch."""


def find_settled(system: AbstractSystem, waveform: Waveforms, given: Mapping[str, Any], tolerance: float) -> Restart:
    """Return the start that a table specifies.

    Raises:
        InputError: no start was found, or the drives have no period.
        SolveError: a search reached an impossible state.
    """
    search = _Search(system, waveform, tolerance)
    return search.find_equilibrium() if given[AT] == EQUILIBRIUM else search.find_cycle(given.get(PERIOD))


@dataclass(frozen=True)
class _Search:
    """Search for the start of a run."""

    system: AbstractSystem
    waveform: Waveforms
    tolerance: float

    def find_equilibrium(self) -> Restart:
        """Return the equilibrium under the first values of the drives."""
        waves = by_name(self.system, self.waveform)
        constants = {name: Constant(level=one.value(0.0)) for name, one in waves.items()}
        step = longest_step(self.system)
        length = REST * step if step < float("inf") else 1.0

        def rests(result: Result) -> float:
            half = len(result.times) // 2
            return self._worst(result, lambda column: max(column[half:]) - min(column[half:]), least_only=True)

        start, moved = HOME, [float("inf")]
        while len(moved) <= MOST_RESTS and not min(moved[:-RESTLESS], default=float("inf")) < 2.0 * min(
            moved[-RESTLESS:]
        ):
            start, by = self._march(constants, length, start, rests)
            if by <= self.tolerance:
                return start
            moved.append(by)
            length *= 2.0
        raise InputError(
            f"{WHERE} The system does not reach a steady state under the first values of its drives: in the last "
            f"{0.25 * length:.4g} s the outputs still changed by {moved[-1]:.2g} times the smallest range that counts."
        )

    def find_cycle(self, period: float | None) -> Restart:
        """Return the start of a period [s] that ends in its initial state."""
        waves = by_name(self.system, self.waveform)
        period = self._find_period(waves) if period is None else period
        for name, one in waves.items():
            require_periodic(name, one, period)

        def closes(result: Result) -> float:
            return self._worst(result, lambda column: abs(column[-1] - column[0]))

        start, open_by = HOME, float("inf")
        for _ in range(MOST_CYCLES):
            start, open_by = self._march(waves, period, start, closes)
            if open_by <= self.tolerance:
                return start
        raise InputError(
            f"{WHERE} The cycle of {period:.6g} s does not close: after {MOST_CYCLES} of them it still ends "
            f"{open_by:.2g} of a range from where it began, more than the tolerance of {self.tolerance:.2g}."
        )

    def _find_period(self, waves: Mapping[str, AbstractWaveform]) -> float:
        """Return the common period of all drives [s]; raise an error with a hint without one."""
        try:
            return find_period(waves)
        except InputError as error:
            raise InputError(f'{WHERE} {error} Or give their `period`, such as `period = "2 s"`.') from None

    def _march(
        self, waves: Mapping[str, AbstractWaveform], length: float, start: Restart, judge: Callable[[Result], float]
    ) -> tuple[Restart, float]:
        """Return the state after a time [s], and the judgement of the run."""
        result = simulate(
            self.system, waves, length, tolerance=0.5 * self.tolerance, samples=LOOKED, start=start
        ).require()
        return result.restarts[-1].at_time_zero(), judge(result)

    def _worst(self, result: Result, measure: Callable[[Any], float], least_only: bool = False) -> float:
        """Return the largest measure of a judged column, relative to its range or smallest relevant range."""
        ratios = [0.0]
        for name, least in self.system.convergence_scales().items():
            column = result.columns[name]
            ratios.append(measure(column) / (least if least_only else max(least, max(column) - min(column))))
        return max(ratios)


def require_periodic(name: str, waveform: AbstractWaveform, period: float) -> None:
    """Raise `InputError` for a waveform that changes after a period [s]."""
    places = [period * (k + 0.37) / LOOKED for k in range(LOOKED)]
    pairs = [(waveform.value(t), waveform.value(t + period)) for t in places]
    size = max(abs(a) for a, _ in pairs)
    for time, (a, b) in zip(places, pairs, strict=True):
        if abs(a - b) > 1e-6 * size:
            raise InputError(
                f"{WHERE} Drive `{name}` does not repeat after {period:.6g} s: it is {a:.6g} at {time:.6g} s, "
                f"but {b:.6g} a period later."
            )
