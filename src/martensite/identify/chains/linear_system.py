"""Linear systems in discrete time: a chain for small signals, and linear blocks.

    x_{t+1} = A x_t + B u_t,    y_t = C x_t + D u_t

u, x and y are deviations from an operating point. Responses exclude states that the inputs do not reach, such as a
play inside its gap: that is exact and removes their eigenvalue 1 from the poles.

The kernel of a linear block is linear, so its responses to each single state and input are the matrices. They belong
to the sample time; delays are separate states.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np

from martensite.base.errors import ParameterError
from martensite.identify.blocks.base import AbstractBlock, Numbers
from martensite.identify.blocks.state_space import StateSpace
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.kernels import floats

CIRCLE = 1e-12
"""Distance of a pole from 1 below which the static gain is undefined."""


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
    state: Numbers
    outputs: Numbers
    input_names: tuple[str, ...] = ()
    output_names: tuple[str, ...] = ()

    @cached_property
    def active(self) -> Numbers:
        """Return the indices of the states that inputs reach and that act on outputs."""
        reached = _find_reachable(np.any(self.b != 0.0, axis=1), self.a != 0.0)
        felt = _find_reachable(np.any(self.c != 0.0, axis=0), self.a.T != 0.0)
        return np.flatnonzero(reached & felt)

    @property
    def standing(self) -> int:
        """Return the number of other states."""
        return len(self.a) - len(self.active)

    def reduce_states(self) -> LinearSystem:
        """Return the system with its active states alone."""
        active = self.active
        return replace(
            self, a=self.a[np.ix_(active, active)], b=self.b[active], c=self.c[:, active], state=self.state[active]
        )

    def poles(self) -> Numbers:
        """Return the poles in the z plane, slowest first."""
        poles = np.linalg.eigvals(self.reduce_states().a)
        return poles[np.argsort(-np.abs(poles), kind="stable")]

    def time_constants(self) -> Numbers:
        """Return -T_s/log|z| of every pole [s], longest first; infinite on the unit circle."""
        with np.errstate(divide="ignore"):
            rate = -np.log(np.abs(self.poles()))
            return np.where(rate > 0.0, self.interval / np.where(rate > 0.0, rate, 1.0), np.inf)

    def gain(self) -> Numbers:
        """Return the static gain C (I - A)⁻¹ B + D, shape (outputs, inputs).

        Raises:
            ParameterError: a pole lies at 1.
        """
        slim = self.reduce_states()
        if len(slim.a) and np.min(np.abs(slim.poles() - 1.0)) < CIRCLE:
            raise ParameterError("The linear system integrates, so it has no steady-state gain.")
        return self.d + slim.c @ np.linalg.solve(np.eye(len(slim.a)) - slim.a, slim.b)

    def frequency_response(self, frequencies: Any) -> Numbers:
        """Return C (z I - A)⁻¹ B + D at z = exp(2πi f T_s), f [Hz]; shape (frequencies, outputs, inputs).

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
        """Return deviations of the outputs (samples, outputs) for deviations of the inputs, from the steady state."""
        u = np.asarray(deviations, dtype=float)
        u = u[:, None] if u.ndim == 1 else u
        slim = self.reduce_states()
        x, y = np.zeros(len(slim.a)), np.empty((len(u), len(self.d)))
        for t, row in enumerate(u):
            y[t] = slim.c @ x + slim.d @ row
            x = slim.a @ x + slim.b @ row
        return y

    def step_response(self, duration: float, number: int = 0) -> tuple[Numbers, Numbers]:
        """Return times [s] and outputs (samples, outputs) after a unit step of one input at 0 s."""
        u = np.zeros((max(round(duration / self.interval), 1) + 1, self.b.shape[1]))
        u[:, number] = 1.0
        return self.interval * np.arange(len(u)), self.simulate(u)


def _find_reachable(first: Numbers, through: Numbers) -> Numbers:
    """Return the states reached from the first ones, where `through[i, j]` is True if j moves i."""
    reached = first
    while True:
        more = reached | np.any(through[:, reached], axis=1)
        if np.array_equal(more, reached):
            return reached
        reached = more


class Orders(NamedTuple):
    """Number of numerator coefficients, poles, and delay."""

    nb: int
    nf: int
    nk: int


@runtime_checkable
class _KnowsPoles(Protocol):
    def poles(self, theta: Numbers, dt: float) -> Numbers: ...


def find_orders(block: AbstractBlock) -> Orders | None:
    """Return the orders of an `oe` or `ss` of one input and output, else None."""
    if isinstance(block, TransferFunction):
        return Orders(int(block.nb), int(block.nf), int(block.nk))
    if isinstance(block, StateSpace) and block.linear and (block.inputs, block.outputs) == (1, 1):
        n, nk = int(block.order), int(block.nk)
        return Orders(n + (nk == 0), n, nk)
    return None


def build_state_space(block: AbstractBlock, theta: Numbers, dt: float) -> LinearSystem:
    """Return the state space of a linear block without its offset, for a sample time [s].

    Raises:
        ParameterError: the block is not linear.
    """
    if not block.linear:
        raise ParameterError(f"Block `{block.text()}` is not linear, so it has no poles or zeros.")
    states, inputs, outputs = block.states(), block.inputs, block.outputs

    def stepped(moving: Numbers) -> Numbers:
        state, x = list(moving[:states]), list(moving[states:])
        y, after = block.step(floats, list(map(float, theta)), state, x, dt)
        return np.array([*after, *y], dtype=float)

    zero = stepped(np.zeros(states + inputs))
    whole = np.zeros((states + outputs, states + inputs))
    for k, unit in enumerate(np.eye(states + inputs)):
        whole[:, k] = stepped(unit) - zero
    return LinearSystem(
        whole[:states, :states],
        whole[:states, states:],
        whole[states:, :states],
        whole[states:, states:],
        dt,
        np.zeros(inputs),
        np.zeros(states),
        zero[states:],
    )


def find_poles(block: AbstractBlock, theta: Numbers, dt: float) -> Numbers:
    """Return the poles z of a linear block, without the poles of delays if it knows its own."""
    if isinstance(block, _KnowsPoles):
        return block.poles(theta, dt)
    return np.linalg.eigvals(build_state_space(block, theta, dt).a)


def find_zeros(block: AbstractBlock, theta: Numbers, dt: float) -> Numbers:
    """Return the zeros z of a linear block of one input and output, without zeros at 0.

    Raises:
        ParameterError: the block is not linear, or has several inputs or outputs.
    """
    if (block.inputs, block.outputs) != (1, 1):
        raise ParameterError(f"Block `{block.text()}` has several inputs or outputs; zeros are those of one of each.")
    system = build_state_space(block, theta, dt)
    numerator, _ = find_fraction(system)
    size = np.abs(numerator)
    first = int(np.argmax(size > 1e-9 * size.max())) if size.max() > 0.0 else len(size)
    roots = np.roots(numerator[first:])
    orders = find_orders(block)
    roots = roots[np.argsort(-np.abs(roots))][: orders.nb - 1 if orders else None]
    return roots[np.abs(roots) > 1e-9]


def find_fraction(system: LinearSystem) -> tuple[Numbers, Numbers]:
    """Return numerator and denominator in falling powers of z, of a system of one input and output."""
    denominator = np.atleast_1d(np.poly(system.a))
    # det(zI - A + B C) = det(zI - A) (1 + C (zI - A)⁻¹ B)
    closed = np.atleast_1d(np.poly(system.a - system.b @ system.c))
    return closed + (system.d[0, 0] - 1.0) * denominator, denominator
