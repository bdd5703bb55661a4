r"""Equations of a periodic motion.

P(s; T, λ) - s - 2π e_φ = 0,        φ = φ₀

The unknowns are the state s, the parameters λ and, for a rotor under constant drives, the time T of a turn. P
integrates over the steps of a period. Periodic drives prescribe T, without a rotor angle φ and its 2π.

Pure counters (a charge) have a unit column in the Jacobian of P, and constant memory has a unit row. These states
have no equation and remain constant. Such directions are neutral, not unstable. Rate-independent hysteresis has a
family of periodic states, and history selects a member.

The classical averaged theory of the Sommerfeld effect neglects the speed variation within a turn; these equations
include it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.steady.continuation import LinearisedEquations
from martensite.simulate.steady.stretch import Stretch

TURN = 2.0 * math.pi
INERT = 1e-13
"""Largest distance of a neutral row or column from the unit matrix, as a fraction of the largest entry."""
NEUTRAL = 1e-6
"""Largest distance of a neutral Floquet multiplier from the unit circle."""
LEAST_SIZE = 0.02
"""Size of a parameter near 0, as a fraction of its range."""


@dataclass(frozen=True)
class VariedNumber:
    """Drive or system parameter that varies along a curve."""

    name: str
    unit: str
    """SI unit."""
    path: str | None = None
    """Full path in the system; None for a drive."""
    drive: int = -1
    """Index of the drive."""
    span: float = 1.0
    """Range of the variation."""


@dataclass(frozen=True, eq=False)
class PeriodGrid:
    """Drive inputs in the steps of a period."""

    step_inputs: Numbers
    """Drive inputs and step lengths, (steps, inputs)."""
    times: Numbers
    """Start of every step and end of the last [s]."""
    signals: Numbers
    """Signals at these times, (steps + 1, drives)."""


@dataclass(frozen=True)
class Stability:
    """Growth of small changes of a periodic motion per period."""

    multipliers: Numbers
    """Floquet multipliers: growth factors per period, without neutral directions."""
    neutral: int
    """Number of directions with constant changes, such as counters and unused memory."""

    @property
    def largest(self) -> float:
        """Return the largest absolute multiplier; 0 without multipliers."""
        return float(np.abs(self.multipliers).max(initial=0.0))

    @property
    def stable(self) -> bool:
        """Return whether all changes decay, except neutral ones."""
        return self.largest < 1.0


class PeriodicMotion:
    """Equations of a period; the last unknown is the continuation parameter."""

    settled = 1e-9
    """Change over a period below which a state is periodic."""

    def __init__(
        self,
        system: AbstractSystem,
        signals: Sequence[float] | Numbers,
        varied: Sequence[VariedNumber],
        *,
        rotor: int | None = None,
        steps: int = 0,
        grid: PeriodGrid | None = None,
    ) -> None:
        """Store the system with its signals and parameters, and a rotor or a known period.

        Args:
            system: system of the motion.
            signals: constant signals of all drives; unused with a grid.
            varied: varied parameters.
            rotor: index of the rotor angle in the state.
            steps: number of steps per turn.
            grid: inputs of a known period.
        """
        self.varied, self.rotor, self.steps, self.grid = tuple(varied), rotor, steps, grid
        self.signals = np.array(signals, float)
        self.stretch = Stretch(system, [one.path for one in varied if one.path is not None])
        self.size = self.stretch.size
        self.angle = 0.0
        """Angle of the rotor at the begin of the period [rad]."""
        self._last_march: tuple[Numbers, Numbers, Numbers] | None = None
        """The last point at which it was marched, and what came of it."""

    @property
    def times(self) -> int:
        """Return the number of unknown times: one for a rotor."""
        return 0 if self.rotor is None else 1

    def period(self, point: Numbers) -> float:
        """Return the length of the period [s]."""
        return float(point[self.size]) if self.grid is None else float(self.grid.times[-1])

    def read_signals(self, point: Numbers) -> Numbers:
        """Return all drives at the parameters of a point."""
        signals = self.signals.copy()
        for one, value in zip(self.varied, point[self.size + self.times :], strict=True):
            if one.path is None:
                signals[one.drive] = value
        return signals

    def march(self, point: Numbers) -> tuple[Numbers, Numbers]:
        """Return the states of a period, and the Jacobian of the last state by all unknowns."""
        if self._last_march is None or not np.array_equal(self._last_march[0], point):
            self._last_march = (np.array(point), *self._march(point))
        return self._last_march[1], self._last_march[2]

    def _march(self, point: Numbers) -> tuple[Numbers, Numbers]:
        first, values = self.size + self.times, point[self.size + self.times :]
        inside = [k for k, one in enumerate(self.varied) if one.path is not None]
        self.stretch.set_moving([float(values[k]) for k in inside])
        moves = np.zeros((len(inside), len(point)))
        moves[range(len(inside)), [first + k for k in inside]] = 1.0
        given, dgiven = self._feed(point)
        seeds = np.eye(self.size, len(point))
        end = self.stretch.march(point[: self.size], given, seeds, dgiven, moves)
        return end.states, end.slopes

    def go_on(self, state: Numbers) -> Numbers:
        """Return the state after a known period, without derivatives."""
        if self.grid is None:
            raise InputError("The period of this motion is not known.")
        given, none = self.grid.step_inputs, np.zeros((0, 0))
        dgiven = np.zeros((*given.shape, 0))
        return self.stretch.march(state, given, np.zeros((self.size, 0)), dgiven, none).states[-1]

    def measure_change(self, state: Numbers) -> float:
        """Return the largest change of the state over a period, relative to its range."""
        return float(np.abs(self.linearise(state).residual).max(initial=0.0))

    def signals_at_begin(self) -> Numbers:
        """Return all drives at the start of the period."""
        return self.signals if self.grid is None else self.grid.signals[0]

    def _feed(self, point: Numbers) -> tuple[Numbers, Numbers]:
        """Return the inputs of all steps, and their derivatives by the unknowns."""
        if self.grid is not None:
            return self.grid.step_inputs, np.zeros((*self.grid.step_inputs.shape, len(point)))
        row, slopes = self.stretch.hold(self.read_signals(point))
        change = np.zeros((len(row) + 1, len(point)))
        change[-1, self.size] = 1.0 / self.steps
        for k, one in enumerate(self.varied, start=self.size + 1):
            if one.path is None:
                change[:-1, k] = slopes[:, one.drive]
        given = np.append(row, point[self.size] / self.steps)
        return np.tile(given, (self.steps, 1)), np.broadcast_to(change, (self.steps, *change.shape))

    def linearise(self, point: Numbers) -> LinearisedEquations:
        """Return the scaled residual of the period and its derivatives."""
        n = self.size
        states, slopes = self.march(point)
        residual, jacobian = states[-1] - states[0], slopes - np.eye(n, len(point))
        inert = find_inert(slopes[:, :n])
        sizes = self._choose_sizes(states, point)
        if self.rotor is not None:
            residual[self.rotor] -= TURN
            inert[self.rotor] = False
        residual[inert] = 0.0
        jacobian[inert] = np.eye(n, len(point))[inert]
        residual, jacobian = residual / sizes[:n], jacobian / sizes[:n, None]
        if self.rotor is not None:
            phase = np.eye(1, len(point), self.rotor)
            residual = np.append(residual, point[self.rotor] - self.angle)
            jacobian = np.vstack([jacobian, phase])
        return LinearisedEquations(residual, jacobian, sizes)

    def _choose_sizes(self, states: Numbers, point: Numbers) -> Numbers:
        """Return the sizes of the states in the period, of the time, and of the parameters."""
        largest = np.maximum(np.abs(states).max(axis=0), 1e-12)
        if self.rotor is not None:
            largest[self.rotor] = 1.0
        spans = np.array([LEAST_SIZE * one.span for one in self.varied])
        values = np.maximum(np.abs(point[self.size + self.times :]), spans)
        return np.concatenate([largest, point[self.size : self.size + self.times], values])

    def judge(self, point: Numbers) -> Stability:
        """Return the Floquet multipliers at a solution.

        For a rotor they belong to the map between passages of its angle. The end time is corrected by dT = -(dφ of
        the state)/(dφ of the time).
        """
        n, k = self.size, self.rotor
        _, slopes = self.march(point)
        matrix = slopes[:, :n]
        if k is None:
            return judge_stability(matrix)
        others = np.arange(n) != k
        matrix = matrix - np.outer(slopes[:, n], matrix[k]) / slopes[k, n]
        return judge_stability(matrix[np.ix_(others, others)])

    def observe(self, point: Numbers) -> tuple[Numbers, dict[str, Numbers]]:
        """Return the times [s] and outputs of a period."""
        states, _ = self.march(point)
        if self.grid is not None:
            return self.grid.times, self.stretch.observe(states, self.grid.signals)
        signals = np.tile(self.read_signals(point), (len(states), 1))
        return np.linspace(0.0, self.period(point), len(states)), self.stretch.observe(states, signals)


def find_inert(matrix: Numbers) -> Numbers:
    """Return the states that only count or only store: columns or rows of the unit matrix."""
    aside = np.abs(matrix - np.eye(len(matrix))) <= INERT * max(np.abs(matrix).max(), 1.0)
    return np.all(aside, axis=0) | np.all(aside, axis=1)


def judge_stability(matrix: Numbers) -> Stability:
    """Return the multipliers of d(state after)/d(state before), with neutral ones separate."""
    inert = find_inert(matrix)
    multipliers = np.linalg.eigvals(matrix[np.ix_(~inert, ~inert)])
    still = np.abs(multipliers - 1.0) <= NEUTRAL
    return Stability(multipliers[~still], int(inert.sum() + still.sum()))


def index_drives(system: AbstractSystem, levels: Mapping[str, float]) -> Numbers:
    """Return the signals of all drives in order; 0 for drives without a level."""
    return np.array([float(levels.get(one.name, 0.0)) for one in system.drives()])
