"""Identification of the hysteresis of `inverse-play` from a slow record.

Plays and a curve behind them are estimated together (`prandtl-ishlinskii | piecewise-linear`). The curve is then fitted
again at the same knots so that it is monotone: a flat piece has no inverse.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import nnls

from martensite.base.errors import InputError
from martensite.control.controllers.inverse_play import InversePlay
from martensite.identify.blocks.piecewise_linear import PiecewiseLinear
from martensite.identify.blocks.prandtl_ishlinskii import PrandtlIshlinskii
from martensite.identify.chains.estimate import ChainEstimate, Options, estimate_chain
from martensite.identify.operators.play import PlaySum
from martensite.signals.sampling.sampled import Numbers, Sampled

FLATTEST = 1e-3
"""Least slope of an identified curve over its mean slope."""


class IdentifiedHysteresis(NamedTuple):
    """A hysteresis and a curve, identified from a record."""

    operator: PlaySum
    knots: tuple[float, ...]
    outputs: tuple[float, ...]
    estimate: ChainEstimate

    def controller(self, **others: Any) -> InversePlay:
        """Return the controller that inverts the hysteresis.

        Args:
            others: `measured`, `reference` and `feedback` of the controller.
        """
        return InversePlay(
            thresholds=self.operator.thresholds,
            weights=self.operator.weights,
            knots=self.knots,
            outputs=self.outputs,
            **others,
        )

    def simulate(self, signals: Numbers) -> Numbers:
        """Return the outputs for signals from the initial state, both of shape (samples,)."""
        x, y = np.array(self.knots), np.array(self.outputs)
        w = self.operator.simulate(signals)
        low = y[0] + (w - x[0]) * (y[1] - y[0]) / (x[1] - x[0])
        high = y[-1] + (w - x[-1]) * (y[-1] - y[-2]) / (x[-1] - x[-2])
        return np.where(w < x[0], low, np.where(w > x[-1], high, np.interp(w, x, y)))


def identify_hysteresis(
    record: Sampled, *, plays: int = 8, knots: int = 8, options: Options | None = None
) -> IdentifiedHysteresis:
    """Identify plays and a curve from a slow record.

    The record begins in the steady state and covers the range of signals up and down, so slowly that half the rate
    would give the same loop.

    Args:
        record: one input, the signal, and one output, in SI.
        plays: number of plays.
        knots: number of knots of the curve.
        options: options of the search; default: few starts.

    Raises:
        InputError: the record has several inputs or outputs.
        DataError: the record is too short, or its signal is constant.
    """
    if record.inputs.shape[1] != 1 or record.outputs.shape[1] != 1:
        raise InputError(
            "An inverse hysteresis is identified from a record of one input and one output, but "
            f"`{record.name}` has {record.inputs.shape[1]} and {record.outputs.shape[1]}."
        )
    blocks = (PrandtlIshlinskii(plays=float(plays)), PiecewiseLinear(knots=float(knots)))
    estimate = estimate_chain(blocks, record, options or Options(starts=4, refined=1))
    (hysteresis, curve), (weights, heights) = estimate.chain.blocks, estimate.chain.split()
    if not isinstance(hysteresis, PrandtlIshlinskii):
        raise InputError(f"The chain that was found has no plays: {estimate.chain.text()}.")
    operator = hysteresis.operator(weights)
    places = np.array([value for _, value, _ in curve.describe_numbers(heights)][::2])
    levels = operator.simulate(record.inputs[:, 0])
    values = fit_rising_curve(places, levels, record.outputs[:, 0])
    return IdentifiedHysteresis(operator, tuple(places.tolist()), tuple(values.tolist()), estimate)


def fit_rising_curve(knots: Numbers, levels: Numbers, outputs: Numbers) -> Numbers:
    """Return the values at knots of the monotone piecewise linear curve of least squares, with a least slope.

    Args:
        knots: rising, shape (knots,).
        levels: abscissae of the outputs, shape (samples,).
        outputs: shape (samples,); missing values are NaN.
    """
    measured = np.isfinite(outputs)
    x, y = np.clip(levels[measured], knots[0], knots[-1]), outputs[measured]
    way = 1.0 if np.polyfit(x, y, 1)[0] >= 0.0 else -1.0
    fractions = np.clip((x[:, None] - knots[:-1]) / np.diff(knots), 0.0, 1.0)
    least = FLATTEST * np.ptp(y) * np.diff(knots) / (knots[-1] - knots[0])
    columns = np.column_stack([np.ones(len(x)), -np.ones(len(x)), fractions])
    sizes, _ = nnls(columns, way * y - fractions @ least)
    return way * (sizes[0] - sizes[1] + np.concatenate([[0.0], np.cumsum(sizes[2:] + least)]))
