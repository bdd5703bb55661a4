"""Operating points of a chain, its linear system there, and its static curve.

The linear system follows exactly from the partial derivatives of every block (`plan`). A block with hysteresis has a
different slope for every history and direction. Without a history every play is in the middle of its gap, and small
signals do not move it. After a history a play may be at the edge of its gap, where continuing inputs move it and
reversing inputs do not. A small `push` selects the direction. Without a push, a play at its edge counts as standing
still.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from martensite.base.errors import InputError, SolveError
from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.engine import step_block
from martensite.identify.chains.linear_system import LinearSystem
from martensite.signals.sampling.sampled import Sampled

SETTLED = 1e-9
"""Relative change of a state that counts as settled."""
DOUBLINGS = 12


class LinearisationPoint(NamedTuple):
    """An operating point: constant input, state and output."""

    inputs: Numbers
    state: Numbers
    outputs: Numbers


def operating_point(chain: Chain, level: Any, history: Numbers | Sampled | None = None) -> LinearisationPoint:
    """Return the steady state of a chain under a constant input.

    Args:
        chain: the model.
        level: input, a number or one for each input.
        history: earlier inputs from the steady state, shape (samples, inputs); it matters for hysteresis.

    Raises:
        InputError: the level or the history does not fit the inputs.
        SolveError: the chain does not settle.
    """
    u = np.atleast_1d(np.asarray(level, dtype=float))
    if u.shape != (chain.inputs,) or not np.all(np.isfinite(u)):
        raise InputError(f"Model `{chain.name}` takes {chain.inputs} finite inputs, not {level}.")
    if history is None:
        state = chain.engine.rest(chain.theta, u).state
    else:
        rows = history.inputs if isinstance(history, Sampled) else np.asarray(history, dtype=float)
        rows = rows[:, None] if rows.ndim == 1 else rows
        if rows.ndim != 2 or rows.shape[1] != chain.inputs or not len(rows):
            raise InputError(f"The history of model `{chain.name}` needs {chain.inputs} inputs.")
        state = chain.engine.rest(chain.theta, rows[0]).state
        chain.engine.simulate(chain.theta, rows, state)
        _settle_state(chain, u, state)
    y = chain.engine.simulate(chain.theta, u[None], state.copy())[0]
    return LinearisationPoint(u, state, y)


def _settle_state(chain: Chain, u: Numbers, state: Numbers) -> None:
    samples = 256
    for _ in range(DOUBLINGS):
        before = state.copy()
        chain.engine.simulate(chain.theta, np.tile(u, (samples, 1)), state)
        size = max(float(np.max(np.abs(state), initial=0.0)), 1e-300)
        if float(np.max(np.abs(state - before), initial=0.0)) <= SETTLED * size:
            return
        samples *= 2
    raise SolveError(
        f"Model `{chain.name}` does not reach a steady state under a constant input of "
        f"{', '.join(f'{x:.6g}' for x in u)} within {samples} samples."
    )


def linearise_chain(
    chain: Chain, level: Any, history: Numbers | Sampled | None = None, push: Any = 0.0
) -> LinearSystem:
    """Return the linear system of a chain around an operating point (see `operating_point`).

    Args:
        chain: the model.
        level: input, a number or one for each input.
        history: earlier inputs from the steady state.
        push: small change of the input in the direction of small signals, for blocks with hysteresis.

    Raises:
        InputError: the level or the history does not fit the inputs.
        SolveError: the chain does not settle.
    """
    point = operating_point(chain, level, history)
    if not np.any(push):
        return linearise_around(chain, point)
    u, state = point.inputs + np.asarray(push, dtype=float), point.state.copy()
    _settle_state(chain, u, state)
    return linearise_around(chain, point, _find_entering(chain, u, state))


def linearise_around(chain: Chain, point: LinearisationPoint, pushed: Sequence[Numbers] | None = None) -> LinearSystem:
    """Return the linear system around any state and input; `pushed` replaces the inputs of blocks with memory."""
    engine = chain.engine
    states, inputs = engine.plan.states, chain.inputs
    moving = states + inputs  # further columns belong to the free numbers
    functions = _bind_blocks(chain)
    entering = _find_entering(chain, point.inputs, point.state)
    a, b = np.zeros((states, states)), np.zeros((states, inputs))
    state_columns = np.eye(states, moving + engine.plan.columns)
    reach = np.hstack([np.zeros((inputs, states)), np.eye(inputs, inputs + engine.plan.columns)])
    output_slopes = np.zeros((len(engine.taps), moving))
    first = 0
    for k, piece in enumerate(engine.plan.pieces):
        rows = slice(first, first + piece.block.states())
        remembers = pushed is not None and piece.block.states() > 0
        x = pushed[k] if pushed is not None and remembers else entering[k]
        _, reach, _, after = step_block(piece, functions, x, reach, point.state[rows], state_columns[rows], moving)
        a[rows], b[rows] = np.split(after[:, :moving], [states], axis=1)
        for place, (number, channel) in enumerate(engine.taps):
            if number == k:
                output_slopes[place] = reach[channel, :moving]
        first = rows.stop
    c, d = np.split(output_slopes, [states], axis=1)
    return LinearSystem(
        a, b, c, d, chain.interval, point.inputs, point.state, point.outputs, chain.input_names, chain.output_names
    )


def _bind_blocks(chain: Chain) -> Any:
    given = [float(value) for block in chain.blocks for value in block.fixed_values()]
    program = chain.engine.plan.program
    return program.bind_floats(*map(float, chain.theta), *given, float(chain.interval))


def _find_entering(chain: Chain, u: Numbers, state: Numbers) -> list[Numbers]:
    functions, x, inputs, first = _bind_blocks(chain), u, [], 0
    for piece in chain.engine.plan.pieces:
        last = first + piece.block.states()
        inputs.append(x[: piece.block.inputs])
        values = functions[f"v{piece.step.name}"](*map(float, inputs[-1]), *map(float, state[first:last]))
        x, first = np.array(values[: piece.block.outputs]), last
    return inputs


def static_curve(
    chain: Chain, low: float, high: float, points: int = 101, number: int = 0, others: Any = None
) -> tuple[Numbers, Numbers]:
    """Return the levels of one input, and the steady outputs (points, outputs) of the chain.

    A chain with hysteresis is without a history at each level.

    Args:
        chain: the model.
        low: first level.
        high: last level.
        points: number of levels.
        number: number of the varied input.
        others: levels of all inputs; default: 0.

    Raises:
        InputError: fewer than 2 points, or levels that do not fit.
    """
    if points < 2 or not np.isfinite(low) or not np.isfinite(high):
        raise InputError("A static curve needs at least 2 points between finite levels.")
    levels = np.linspace(low, high, points)
    base = np.zeros(chain.inputs) if others is None else np.asarray(others, dtype=float)
    rows = np.tile(base, (points, 1))
    rows[:, number] = levels
    return levels, np.array([operating_point(chain, row).outputs for row in rows])
