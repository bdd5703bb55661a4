r"""A period of a system as equations: after it, everything is as before.

    P(s; T, λ) - s - 2π e_φ = 0,        φ = φ₀

Unknown are the state s, for a rotor under held drives also the time T of its turn, and the parameters λ. P marches
through the steps of a period. Under drives of a known period T is given, and there is neither a rotor's angle φ nor
its 2π.

What only counts up and acts on nothing (a charge) has a column of the unit matrix in P's Jacobian, and what is
remembered and does not change has a row of it: for neither is there an equation, and it stays where it is. Such
directions are neutral, not unstable: rate-independent hysteresis has a whole family of periodic states side by side,
and which of them is met was decided by what happened before.

An averaged rotation, the classical theory of the Sommerfeld effect, leaves out that the speed swings within the turn;
here nothing is left out but what the steps leave out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.steady.continuation import Linearised
from martensite.simulate.steady.stretch import Stretch

TURN = 2.0 * math.pi
INERT = 1e-13
"""Largest distance of a neutral row or column from the unit matrix, as a fraction of the largest entry."""
NEUTRAL = 1e-6
"""Largest distance of a neutral Floquet multiplier from the unit circle."""
LEAST_SIZE = 0.02
"""Size of a parameter near 0, as a fraction of how far it is varied."""


@dataclass(frozen=True)
class VariedNumber:
    """A drive or a number of the system that moves along a curve."""

    name: str
    unit: str
    """SI unit."""
    path: str | None = None
    """Full path in the system; None for a drive that is held."""
    drive: int = -1
    """Place of the drive among the drives."""
    span: float = 1.0
    """Range of the variation."""


@dataclass(frozen=True, eq=False)
class PeriodGrid:
    """Inputs from the drives in the steps of a period."""

    given: Numbers
    """Inputs from the drives, and the length of the step, (steps, inputs)."""
    times: Numbers
    """Times at the begin of every step and the end of the last [s]."""
    signals: Numbers
    """At these times, (steps + 1, drives)."""


@dataclass(frozen=True)
class Stability:
    """Growth of a small change of a periodic motion, from period to period."""

    multipliers: Numbers
    """Floquet multipliers: factors of changes in a period, without the neutral directions."""
    neutral: int
    """Number of directions in which a change stays constant, such as counters and unused memory."""

    @property
    def largest(self) -> float:
        """Return the largest size of a multiplier; 0 if there is none."""
        return float(np.abs(self.multipliers).max(initial=0.0))

    @property
    def stable(self) -> bool:
        """Return whether every change that is not neutral decays."""
        return self.largest < 1.0


class PeriodicMotion:
    """Equations of a period; the last unknown is the parameter that is followed."""

    settled = 1e-9
    """Change over a period at which a state repeats itself."""

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
        """Take a system, its held signals and what is varied; a rotor and its steps, or the grid of a known period.

        Args:
            system: whose motion it is.
            signals: of all drives, held; unused with a grid.
            varied: what the parameters are.
            rotor: place of its angle in the state.
            steps: in a turn.
            grid: of a period that is known.
        """
        self.varied, self.rotor, self.steps, self.grid = tuple(varied), rotor, steps, grid
        self.signals = np.array(signals, float)
        self.stretch = Stretch(system, [one.path for one in varied if one.path is not None])
        self.size = self.stretch.size
        self.angle = 0.0
        """Angle of the rotor at the begin of the period [rad]."""
        self._known: tuple[Numbers, Numbers, Numbers] | None = None
        """The last point at which it was marched, and what came of it."""

    @property
    def times(self) -> int:
        """Return the number of unknown times: one for a rotor."""
        return 0 if self.rotor is None else 1

    def period(self, point: Numbers) -> float:
        """Return the length of the period [s]."""
        return float(point[self.size]) if self.grid is None else float(self.grid.times[-1])

    def read_signals(self, point: Numbers) -> Numbers:
        """Return all drives under the parameters of a point."""
        signals = self.signals.copy()
        for one, value in zip(self.varied, point[self.size + self.times :], strict=True):
            if one.path is None:
                signals[one.drive] = value
        return signals

    def march(self, point: Numbers) -> tuple[Numbers, Numbers]:
        """Return the states of a period, and the Jacobian of the last one by all unknowns."""
        if self._known is None or not np.array_equal(self._known[0], point):
            self._known = (np.array(point), *self._march(point))
        return self._known[1], self._known[2]

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
        given, none = self.grid.given, np.zeros((0, 0))
        dgiven = np.zeros((*given.shape, 0))
        return self.stretch.march(state, given, np.zeros((self.size, 0)), dgiven, none).states[-1]

    def measure_change(self, state: Numbers) -> float:
        """Return the largest change of the state over a period, in sizes of what it does in it."""
        return float(np.abs(self.linearise(state).residual).max(initial=0.0))

    def signals_at_begin(self) -> Numbers:
        """Return all drives at the begin of the period."""
        return self.signals if self.grid is None else self.grid.signals[0]

    def _feed(self, point: Numbers) -> tuple[Numbers, Numbers]:
        """Return the inputs of all steps, and their derivatives by the unknowns."""
        if self.grid is not None:
            return self.grid.given, np.zeros((*self.grid.given.shape, len(point)))
        row, slopes = self.stretch.hold(self.read_signals(point))
        change = np.zeros((len(row) + 1, len(point)))
        change[-1, self.size] = 1.0 / self.steps
        for k, one in enumerate(self.varied, start=self.size + 1):
            if one.path is None:
                change[:-1, k] = slopes[:, one.drive]
        given = np.append(row, point[self.size] / self.steps)
        return np.tile(given, (self.steps, 1)), np.broadcast_to(change, (self.steps, *change.shape))

    def linearise(self, point: Numbers) -> Linearised:
        """Return the residual of the period in sizes of the states, and its derivatives."""
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
        return Linearised(residual, jacobian, sizes)

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

        For a rotor they are those of the map from one passage of its angle to the next, of which a shift in time is no
        part: a turn that ends late by its state, dT = -(dφ of the state)/(dφ of the time), is ended earlier.
        """
        n, k = self.size, self.rotor
        _, slopes = self.march(point)
        matrix = slopes[:, :n]
        if k is None:
            return judge_stability(matrix)
        kept = np.arange(n) != k
        matrix = matrix - np.outer(slopes[:, n], matrix[k]) / slopes[k, n]
        return judge_stability(matrix[np.ix_(kept, kept)])

    def observe(self, point: Numbers) -> tuple[Numbers, dict[str, Numbers]]:
        """Return the times [s] and outputs of a period."""
        states, _ = self.march(point)
        if self.grid is not None:
            return self.grid.times, self.stretch.observe(states, self.grid.signals)
        signals = np.tile(self.read_signals(point), (len(states), 1))
        return np.linspace(0.0, self.period(point), len(states)), self.stretch.observe(states, signals)


def find_inert(matrix: Numbers) -> Numbers:
    """Which states only count up or only remember: their column or row is that of the unit matrix."""
    aside = np.abs(matrix - np.eye(len(matrix))) <= INERT * max(np.abs(matrix).max(), 1.0)
    return aside.all(axis=0) | aside.all(axis=1)


def judge_stability(matrix: Numbers) -> Stability:
    """Return the multipliers of d(state after)/d(state before), the neutral ones apart."""
    inert = find_inert(matrix)
    found = np.linalg.eigvals(matrix[np.ix_(~inert, ~inert)])
    still = np.abs(found - 1.0) <= NEUTRAL
    return Stability(found[~still], int(inert.sum() + still.sum()))


def index_drives(system: AbstractSystem, levels: Mapping[str, float]) -> Numbers:
    """Return the signals of all drives in their order; what is not named gets 0."""
    return np.array([float(levels.get(one.name, 0.0)) for one in system.drives()])
