"""State feedback by the linear-quadratic regulator, with an integral of the tracking error.

    J = Σ_k  Σ_i (Δz_i/s_i)² + (I/s_I)² + (Δu/s_u)²,    u = u_0 - K Δz + K_I I

for the plant in discrete time with the integral as a further state (Franklin, Powell and Workman 1998), by the discrete
algebraic Riccati equation. The sizes s are deviations of equal weight (Bryson's rule). With the feed-forward gain

    N = (1 + K M_z)/M_y

and static gains M from the signal, a linear plant reaches any reference without a steady error of the integral.

A plant with hysteresis has a linear system for each branch; one design may serve both, by their mean or by the gains of
the faster branch. Test the design in a run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from scipy.linalg import solve_discrete_are

from martensite.base.errors import ParameterError, SolveError, suggest_name
from martensite.control.controllers.state_feedback import StateFeedback
from martensite.control.synthesis.linear import Readings
from martensite.identify.chains.linear_system import LinearSystem
from martensite.signals.sampling.sampled import Numbers


@dataclass(frozen=True)
class LqrSizes:
    """Deviations of equal weight in the cost."""

    states: tuple[float, ...]
    """Tolerated deviation of every state, in its SI unit; infinite for a state without a weight."""
    integral: float
    """Tolerated integral of the error, in the unit of the error times s."""
    signal: float
    """Tolerated deviation of the signal, in the unit of the source."""


@dataclass(frozen=True, eq=False)
class Regulator:
    """Gains that minimise the cost."""

    readings: Readings
    measured: str
    gains: tuple[float, ...]
    """K, one per state."""
    Ki: float
    """K_I [signal per unit and s]."""
    prefilter: float
    """N."""

    @property
    def linear(self) -> LinearSystem:
        """Return the plant."""
        return self.readings.linear

    def closed_loop_matrix(self) -> Numbers:
        """Return the matrix of the closed loop, states and integral."""
        a, b, _ = augment_plant(self.linear, self.measured)
        return a - b @ np.array([[*self.gains, -self.Ki]])

    def poles(self) -> Numbers:
        """Return the poles of the closed loop in the z plane, slowest first."""
        poles = np.linalg.eigvals(self.closed_loop_matrix())
        return poles[np.argsort(-np.abs(poles), kind="stable")]

    def controller(
        self, low: float, high: float, *, reference: Any, names: Sequence[str] | None = None
    ) -> StateFeedback:
        """Return the controller with these gains.

        Args:
            low: least signal.
            high: largest signal.
            reference: waveform of the reference.
            names: names of the states on a bench, such as `estimated.temperature`; default: as in the plant.

        Raises:
            ParameterError: the number of names does not fit.
        """
        states = self.linear.output_names
        called = tuple(names or states)
        if len(called) != len(states):
            raise ParameterError(f"There are {len(states)} states, but {len(called)} names.")
        place = states.index(self.measured)
        at = tuple(float(value) for value in self.linear.state)
        return StateFeedback(
            measured=called[place],
            reference=reference,
            states=called,
            gains=self.gains,
            at=at,
            signal=float(self.linear.inputs[0]),
            level=at[place],
            prefilter=self.prefilter,
            Ki=self.Ki,
            low=low,
            high=high,
        )


def augment_plant(linear: LinearSystem, measured: str) -> tuple[Numbers, Numbers, Numbers]:
    """Return A and B with the integral of the error as the last state, and the row of the measured output."""
    if measured not in linear.output_names:
        raise ParameterError(
            f"`{measured}` is no state of the linear plant. {suggest_name(measured, linear.output_names)}"
        )
    count, row = len(linear.a), linear.c[[linear.output_names.index(measured)]]
    step = -linear.interval * row
    a = np.block([[linear.a, np.zeros((count, 1))], [step @ linear.a, np.ones((1, 1))]])
    return a, np.vstack([linear.b, step @ linear.b]), row


def design_regulator(readings: Readings, measured: str, sizes: LqrSizes) -> Regulator:
    """Return the regulator that minimises the cost of a linear plant with one input.

    Args:
        readings: plant from `realise_readings`, or the mean of both branches.
        measured: state that follows the reference.
        sizes: sizes of the cost.

    Raises:
        ParameterError: a name or the sizes do not fit.
        SolveError: no feedback from these states stabilises the plant.
    """
    linear = readings.linear
    if linear.b.shape[1] != 1 or len(sizes.states) != len(linear.a):
        raise ParameterError(
            f"A regulator has one input and a size per state, but there are "
            f"{linear.b.shape[1]} inputs, {len(linear.a)} states and {len(sizes.states)} sizes."
        )
    every = np.array([*sizes.states, sizes.integral, sizes.signal], dtype=float)
    if not np.all(every > 0.0):
        raise ParameterError(f"All sizes must be above 0, but they are {sizes}.")
    a, b, row = augment_plant(linear, measured)
    gains = solve_riccati(a, b, np.diag(every[:-1] ** -2.0), np.array([[every[-1] ** -2.0]]))[0]
    static_gains = np.linalg.solve(np.eye(len(linear.a)) - linear.a, linear.b)
    prefilter = (1.0 + float(gains[:-1] @ static_gains[:, 0])) / float((row @ static_gains)[0, 0])
    state_gains = tuple(float(gain) for gain in gains[:-1])
    return Regulator(readings, measured, state_gains, -float(gains[-1]), prefilter)


def solve_riccati(a: Numbers, b: Numbers, q: Numbers, r: Numbers) -> Numbers:
    """Return K of u = -K x that minimises Σ xᵀ Q x + uᵀ R u along x_k+1 = A x_k + B u_k.

    Raises:
        SolveError: the equation has no stabilising solution.
    """
    weights = np.diag(q)
    scale = np.sqrt(np.where(weights > 0.0, weights, 1.0))
    inner, into = scale[:, None] * a / scale, scale[:, None] * b
    try:
        p = solve_discrete_are(inner, into, q / np.outer(scale, scale), r)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise SolveError(f"No feedback from these states makes the plant stable: {error}") from None
    k = np.linalg.solve(r + into.T @ p @ into, into.T @ p @ inner)
    return cast("Numbers", k * scale)
