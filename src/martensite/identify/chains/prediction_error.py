"""The prediction error: a chain and the model of its noise, found in turns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.goals import find_expected
from martensite.identify.chains.noise_model import noise_model
from martensite.identify.chains.options import Options
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares
from martensite.search.levenberg_marquardt import Found, minimise_cost

TURNS = 3
"""How often noise model and chain follow each other."""


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
