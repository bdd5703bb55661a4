"""Noise models: the whitening filter of coloured residuals, for the prediction-error focus.

    L(q) v_t = e_t,   L = 1 + l_1 q^-1 + … + l_n q^-n

is autoregressive least squares over samples whose n predecessors are known. With L in the sum of
squares the model is the one of least prediction error; the residuals of that give another L, and
so on in turns.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from martensite.base.errors import DataError
from martensite.identify.blocks.base import Numbers


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
