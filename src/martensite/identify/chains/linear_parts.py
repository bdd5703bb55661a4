"""Linear blocks as linear systems: state space, poles and zeros.

    s⁺ = A s + B x,   y = C s + D x

The kernel of a linear block is linear, so the matrices are what it gives for each state and each
input alone. They belong to the sample time; delays are states of their own.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from martensite.base.errors import ParameterError
from martensite.identify.blocks.base import AbstractBlock, Numbers
from martensite.identify.blocks.state_space import StateSpace
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.linear_system import LinearSystem
from martensite.kernels import floats


class Orders(NamedTuple):
    """Coefficients of the numerator, poles, delay."""

    nb: int
    nf: int
    nk: int


@runtime_checkable
class _KnowsPoles(Protocol):
    def poles(self, theta: Numbers, dt: float) -> Numbers: ...


def find_orders(block: AbstractBlock) -> Orders | None:
    """Orders of an `oe` or `ss` of one input and one output."""
    if isinstance(block, TransferFunction):
        return Orders(int(block.nb), int(block.nf), int(block.nk))
    if isinstance(block, StateSpace) and block.linear and (block.inputs, block.outputs) == (1, 1):
        n, nk = int(block.order), int(block.nk)
        return Orders(n + (nk == 0), n, nk)
    return None


def build_state_space(block: AbstractBlock, theta: Numbers, dt: float) -> LinearSystem:
    """State space of a linear block at a sample time [s]; an offset is left out.

    Raises:
        ParameterError: the block is not linear.
    """
    if not block.linear:
        raise ParameterError(f"Block `{block.text()}` is not linear, so it has no poles or zeros.")
    states, inputs, outputs = block.states(), block.inputs, block.outputs

    def stepped(moving: Numbers) -> Numbers:
        held, x = list(moving[:states]), list(moving[states:])
        y, after = block.step(floats, list(map(float, theta)), held, x, dt)
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
    """Poles z of a linear block, those at 0 of delays left out where it knows its own."""
    if isinstance(block, _KnowsPoles):
        return block.poles(theta, dt)
    return np.linalg.eigvals(build_state_space(block, theta, dt).a)


def find_zeros(block: AbstractBlock, theta: Numbers, dt: float) -> Numbers:
    """Zeros z of a linear block of one input and one output.

    There is one fewer than the numerator has coefficients; those at 0 are left out.

    Raises:
        ParameterError: the block is not linear, or has several inputs or outputs.
    """
    if (block.inputs, block.outputs) != (1, 1):
        raise ParameterError(f"Block `{block.text()}` has several inputs or outputs; zeros are those of one of each.")
    made = build_state_space(block, theta, dt)
    numerator, _ = find_fraction(made)
    size = np.abs(numerator)
    first = int(np.argmax(size > 1e-9 * size.max())) if size.max() > 0.0 else len(size)
    found = np.roots(numerator[first:])
    known = find_orders(block)
    found = found[np.argsort(-np.abs(found))][: known.nb - 1 if known else None]
    return found[np.abs(found) > 1e-9]


def find_fraction(system: LinearSystem) -> tuple[Numbers, Numbers]:
    """Numerator and denominator in falling powers of z, of a system of one input and output."""
    denominator = np.atleast_1d(np.poly(system.a))
    # det(zI - A + B C) = det(zI - A) (1 + C (zI - A)⁻¹ B)
    closed = np.atleast_1d(np.poly(system.a - system.b @ system.c))
    return closed + (system.d[0, 0] - 1.0) * denominator, denominator
