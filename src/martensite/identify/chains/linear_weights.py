"""The numbers of a linear block that are linear once its poles are given, by least squares."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.identify.blocks.base import Numbers
from martensite.identify.blocks.state_space import StateSpace
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.engine import ChainEngine
from martensite.identify.chains.impulse_response import Pair


class LinearStart(NamedTuple):
    """Numbers with which y ≈ gain · block(w) + offset."""

    theta: Numbers
    gain: float
    """1 for a block whose gain is free."""
    offset: float
    """0 for a block with offsets of its own, or of several outputs."""
    error: float
    """Sum of squared errors over the outputs' variances."""


def fit_weights(block: TransferFunction | StateSpace, known: Numbers, pairs: Sequence[Pair], dt: float) -> LinearStart:
    """The start with given first numbers; all others are linear and follow from least squares."""
    theta = np.zeros(len(block.numbers()))
    theta[: len(known)] = known
    own = _find_weights(block, len(known))
    found, error = _solve_squares(ChainEngine([block], dt), theta, own, pairs)
    if not np.isfinite(error):
        return LinearStart(theta, 1.0, 0.0, np.inf)
    if isinstance(block, TransferFunction):
        gain = float(found[0, 0])
        least = 1e-3 * float(np.abs(found[:-1, 0]).max())
        gain = gain if abs(gain) > least else max(least, 1e-300)
        theta[own] = found[1:-1, 0] / gain
        return LinearStart(theta, gain, float(found[-1, 0]), error)
    # C and D row by row, then the offsets
    n, d = int(block.order), block.inputs * (block.nk < 1.0)
    parts = [found[:n].T.ravel(), found[n : n + d].T.ravel()]
    if block.offset == "yes":
        parts.append(found[-1])
    theta[len(known) :] = np.concatenate(parts)
    single = block.offset == "no" and block.outputs == 1
    return LinearStart(theta, 1.0, float(found[-1, 0]) if single else 0.0, error)


def _find_weights(block: TransferFunction | StateSpace, known: int) -> NDArray[np.intp]:
    """Places of the linear numbers; those of the first output, as all sum the same signals."""
    first = ("weight", "c1_", "d1_")
    names = block.numbers()
    return np.array([i for i in range(known, len(names)) if names[i].startswith(first)], np.intp)


def _solve_squares(
    engine: ChainEngine, theta: Numbers, own: NDArray[np.intp], pairs: Sequence[Pair]
) -> tuple[Numbers, float]:
    """Weights of the signals and a constant (the last), and the error over the variances."""
    outputs = np.concatenate([y for _, y in pairs])
    outs = outputs.shape[1]
    total: Numbers | None = None
    for x, y in _collect_signals(engine, theta, own, pairs):
        rows = np.hstack([x, y])
        rows = rows if total is None else np.vstack([total, rows])
        if not np.all(np.isfinite(rows)):
            return np.zeros((0, 0)), np.inf
        total = np.asarray(np.linalg.qr(rows, mode="r"))
    if total is None or len(total) < total.shape[1]:
        return np.zeros((0, 0)), np.inf
    count = total.shape[1] - outs
    top, right = total[:count, :count], total[:count, count:]
    scale = np.maximum(np.linalg.norm(top, axis=0), 1e-300)
    found = np.linalg.lstsq(top / scale, right, rcond=1e-12)[0] / scale[:, None]
    left = np.sum((right - top @ found) ** 2, axis=0) + np.sum(total[count:, count:] ** 2, axis=0)
    spread = np.nanvar(outputs, axis=0)
    return found, float(np.sum(left / np.where(spread > 0.0, spread, 1.0)))


def _collect_signals(
    engine: ChainEngine, theta: Numbers, own: NDArray[np.intp], pairs: Sequence[Pair]
) -> Iterator[Pair]:
    """What the linear numbers weigh, with a constant, and the outputs: rows known in all."""
    single = isinstance(engine.blocks[0], TransferFunction)
    for u, y in pairs:
        for chunk in engine.sensitivities(theta, u):
            known = np.all(np.isfinite(y[chunk.rows]), axis=1)
            first = chunk.outputs[:, :1] if single else chunk.outputs[:, :0]
            ones = np.ones((len(chunk.outputs), 1))
            x = np.hstack([first, chunk.slopes[:, 0, own], ones])
            yield x[known], y[chunk.rows][known]
