"""A linear system in discrete time, as what a chain is for small signals.

    x_{t+1} = A x_t + B u_t,    y_t = C x_t + D u_t

where u, x and y are deviations from an operating point. States that the inputs do not reach
through A and B, such as a play that stands inside its gap, do not take part: they are left out
where a response is computed, which is exact and keeps their eigenvalue 1 out of the poles.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from martensite.base.errors import ParameterError
from martensite.identify.blocks.base import Numbers

CIRCLE = 1e-12
"""Distance of a pole from 1 below which there is no gain at rest."""


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """A linear system around an operating point."""

    a: Numbers
    """A, shape (states, states)."""
    b: Numbers
    """B, shape (states, inputs)."""
    c: Numbers
    """C, shape (outputs, states)."""
    d: Numbers
    """D, shape (outputs, inputs)."""
    interval: float
    """Sample time [s]."""
    inputs: Numbers
    """The input of the operating point."""
    state: Numbers
    """The state of the operating point."""
    outputs: Numbers
    """The output of the operating point."""
    input_names: tuple[str, ...] = ()
    output_names: tuple[str, ...] = ()

    @cached_property
    def active(self) -> Numbers:
        """Numbers of the states that inputs reach and outputs feel."""
        reached = _find_reachable(np.any(self.b != 0.0, axis=1), self.a != 0.0)
        felt = _find_reachable(np.any(self.c != 0.0, axis=0), self.a.T != 0.0)
        return np.flatnonzero(reached & felt)

    @property
    def standing(self) -> int:
        """How many states small signals do not move, or nobody feels."""
        return len(self.a) - len(self.active)

    def reduce_states(self) -> LinearSystem:
        """The same system with its active states alone."""
        kept = self.active
        return replace(self, a=self.a[np.ix_(kept, kept)], b=self.b[kept], c=self.c[:, kept], state=self.state[kept])

    def poles(self) -> Numbers:
        """Poles in the plane of z, the slowest first; stable inside the unit circle."""
        found = np.linalg.eigvals(self.reduce_states().a)
        return found[np.argsort(-np.abs(found), kind="stable")]

    def time_constants(self) -> Numbers:
        """-T_s/log|z| of every pole [s], longest first; infinite on the unit circle."""
        with np.errstate(divide="ignore"):
            rate = -np.log(np.abs(self.poles()))
            return np.where(rate > 0.0, self.interval / np.where(rate > 0.0, rate, 1.0), np.inf)

    def gain(self) -> Numbers:
        """Gain at rest C (I - A)⁻¹ B + D, shape (outputs, inputs).

        Raises:
            ParameterError: a pole lies at 1, so that there is none.
        """
        slim = self.reduce_states()
        if len(slim.a) and np.min(np.abs(slim.poles() - 1.0)) < CIRCLE:
            raise ParameterError("The linear system integrates: it has no gain at rest.")
        return self.d + slim.c @ np.linalg.solve(np.eye(len(slim.a)) - slim.a, slim.b)

    def frequency_response(self, frequencies: Any) -> Numbers:
        """C (z I - A)⁻¹ B + D at z = exp(2πi f T_s), shape (frequencies, outputs, inputs).

        Args:
            frequencies: f [Hz], up to half the sample rate.

        Raises:
            ParameterError: a frequency is not between 0 and 1/(2 T_s).
        """
        f = np.atleast_1d(np.asarray(frequencies, dtype=float))
        most = 0.5 / self.interval
        if not np.all((f >= 0.0) & (f <= most * (1.0 + 1e-12))):
            raise ParameterError(f"Frequencies must be between 0 and half the sample rate, {most:.6g} Hz.")
        slim = self.reduce_states()
        z = np.exp(2j * np.pi * f * self.interval)
        here = z[:, None, None] * np.eye(len(slim.a)) - slim.a
        right = np.broadcast_to(slim.b.astype(complex), (len(f), *slim.b.shape))
        return self.d + slim.c @ np.linalg.solve(here, right)

    def simulate(self, deviations: Any) -> Numbers:
        """Deviations of the outputs (samples, outputs) for those of the inputs, from rest."""
        u = np.asarray(deviations, dtype=float)
        u = u[:, None] if u.ndim == 1 else u
        slim = self.reduce_states()
        x, y = np.zeros(len(slim.a)), np.empty((len(u), len(self.d)))
        for t, row in enumerate(u):
            y[t] = slim.c @ x + slim.d @ row
            x = slim.a @ x + slim.b @ row
        return y

    def step_response(self, duration: float, number: int = 0) -> tuple[Numbers, Numbers]:
        """Times [s] and outputs (samples, outputs) after a unit step of one input at 0 s."""
        u = np.zeros((max(round(duration / self.interval), 1) + 1, self.b.shape[1]))
        u[:, number] = 1.0
        return self.interval * np.arange(len(u)), self.simulate(u)


def _find_reachable(first: Numbers, through: Numbers) -> Numbers:
    """States that are reached from some, where `through[i, j]` says that j moves i."""
    reached = first
    while True:
        more = reached | np.any(through[:, reached], axis=1)
        if np.array_equal(more, reached):
            return reached
        reached = more
