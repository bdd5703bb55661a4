"""Noise models: the whitening filter of coloured residuals, for the prediction-error focus.

    L(q) v_t = e_t,   L = 1 + l_1 q^-1 + … + l_n q^-n

is autoregressive least squares over samples whose n predecessors are known. With L in the sum of
squares the model is the one of least prediction error; the residuals of that give another L, and
so on in turns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from martensite.base.errors import DataError
from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.goals import find_expected
from martensite.identify.chains.options import Options
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares
from martensite.search.levenberg_marquardt import Found, minimise_cost

TURNS = 3
"""How often noise model and chain follow each other."""


def noise_model(residuals: Sequence[Numbers], order: int) -> Numbers:
    """Coefficients 1, l_1 … l_n of L(q).

    Args:
        residuals: of records, shape (samples, outputs), NaN where unknown; outputs count alike.
        order: n.

    Raises:
        DataError: too few samples in a row are known.
    """
    square, cross, count = np.zeros((order, order)), np.zeros(order), 0
    for record in residuals:
        for v in record.T:
            if len(v) <= order:
                continue
            rows = np.lib.stride_tricks.sliding_window_view(v, order + 1)[:, ::-1]
            rows = rows[np.all(np.isfinite(rows), axis=1)]
            square += rows[:, 1:].T @ rows[:, 1:]
            cross += rows[:, 1:].T @ rows[:, 0]
            count += len(rows)
    if count <= 2 * order:
        raise DataError(
            f"A noise model of order {order} needs more than {2 * order} samples with as many "
            f"known before them, not {count}."
        )
    least = 1e-12 * max(float(np.trace(square)), 1e-300) * np.eye(order)
    return np.concatenate([np.ones(1), -np.linalg.solve(square + least, cross)])


def whiten_chain(
    chain: Chain, found: Found, wanted: Sequence[RecordResidual], options: Options
) -> tuple[Found, tuple[RecordResidual, ...]]:
    """The minimum of the prediction error: noise model and chain in turns, from a minimum."""
    aims_ = tuple(wanted)
    prior = find_expected(chain, options)
    for _ in range(TURNS):
        squares = ResidualSquares(chain.engine, aims_, options.ridge, *prior)
        left: list[Numbers] = []
        theta = found.theta[: len(chain.theta)]
        for aim, state in zip(aims_, squares.initial(found.theta), strict=True):
            computed = chain.with_theta(theta).simulate(aim.record, state)
            left.append(((aim.record.outputs - computed) * aim.scale())[aim.skip :])
        filter_ = noise_model(left, options.noise)
        # a record of one sample, such as that of rest, has no noise to be whitened
        aims_ = tuple(replace(a, whitening=filter_) if len(a.record) > 1 else a for a in aims_)
        squares = ResidualSquares(chain.engine, aims_, options.ridge, *prior)
        found = minimise_cost(squares, found.theta, options.iterations)
    return found, aims_
