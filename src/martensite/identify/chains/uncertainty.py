"""Uncertainty of the free parameters and outputs of an estimated chain.

    C = P M P,    P = (JᵀJ)⁺,    M = Σ_b (Σ_{t in b} J_tᵀ e_t)(Σ_{t in b} J_tᵀ e_t)ᵀ

The residuals of a model are coloured; as independent they would give errors many times too small. So they are summed in
blocks longer than their correlation time (White (1982), Econometrica 50; Newey and West (1987), Econometrica 55).
Undetermined directions are removed from P and named.

    band of an output    ŷ ± z √(j C jᵀ + σ_e²)

with its derivatives j and the residual σ_e: C alone is for the model, both are for measurements. All is of first order,
with estimated initial states taken as known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from martensite.base.errors import DataError, ParameterError
from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.engine import ChainStart
from martensite.identify.chains.information_matrix import (
    Flat,
    PrintedNumber,
    Sums,
    block_lengths,
    invert_normal,
    list_rows,
    slopes_of_shown,
    sum_blocks,
)
from martensite.identify.chains.residuals import ResidualSquares
from martensite.search.quantity_text import format_number
from martensite.signals.sampling.sampled import Sampled

LEVEL = 0.95
UNDETERMINED = 1e-3
"""Fraction of a derivative in undetermined directions above which a value is undetermined."""


class OutputBand(NamedTuple):
    """Computed outputs with their band, shape (samples, outputs)."""

    outputs: Numbers
    model: Numbers
    """Half width of the uncertainty of the model."""
    measured: Numbers
    """Half width of the band of measurements."""


@dataclass(frozen=True, eq=False)
class ChainUncertainty:
    """Covariance of the free numbers of a chain."""

    chain: Chain
    covariance: Numbers
    """C, shape (numbers, numbers), without undetermined directions."""
    null: Numbers
    """Undetermined directions, in numbers times `scale`."""
    scale: Numbers
    flat: tuple[Flat, ...]
    residual: Numbers
    """Standard deviation of the residuals of every output, in its unit."""
    blocks: tuple[int, ...]
    """Block length of every record in samples."""
    condition: float
    """Largest over smallest determined eigenvalue of the scaled JᵀJ."""
    inflation: float
    """Mean factor by which errors exceed those of independent residuals."""

    @property
    def errors(self) -> Numbers:
        """Return the standard errors of the free numbers; infinite if undetermined."""
        errors = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        lost = np.linalg.norm(self.null, axis=1) > UNDETERMINED
        return np.where(lost, np.inf, errors)

    @property
    def sentences(self) -> tuple[str, ...]:
        """Return the assumptions and results, one sentence each."""
        count = len(self.chain.theta)
        longest = format_number(max(self.blocks) * self.chain.interval, 3)
        rank = count - self.null.shape[1]
        first = f"The records determine {rank} directions of {count} free numbers."
        if max(self.blocks) == 1:
            kind = "The residuals are taken as independent."
        else:
            kind = (
                f"The residuals are coloured; they count in blocks of {longest} s. Taken as "
                f"independent they would give errors {format_number(self.inflation, 2)} times "
                "smaller."
            )
        return (first, kind, *(one.sentence for one in self.flat))

    def describe_numbers(self) -> list[PrintedNumber]:
        """Return the physical quantities by block, with standard errors (delta method)."""
        lost = np.isinf(self.errors)
        numbers: list[PrintedNumber] = []
        first = 0
        for k, (block, theta) in enumerate(zip(self.chain.blocks, self.chain.split(), strict=True)):
            columns = slice(first, first + len(theta))
            slopes = slopes_of_shown(block, theta)
            scaled = slopes / self.scale[columns]
            null_sizes = np.linalg.norm(scaled @ self.null[columns], axis=1)
            open_ = null_sizes > UNDETERMINED * np.linalg.norm(scaled, axis=1)
            moved = np.linalg.norm(slopes[:, lost[columns]], axis=1)
            numbers += list_rows(k + 1, block, theta, slopes, self.covariance[columns, columns], open_, moved)
            first = columns.stop
        return numbers

    def band(self, record: Sampled, level: float = LEVEL, state: Numbers | None = None) -> OutputBand:
        """Return the outputs along a record with the band that holds a fraction `level` of the samples.

        Args:
            record: inputs of the run.
            level: probability.
            state: state at the first sample, taken as known; default: the steady state under the first inputs.

        Raises:
            ParameterError: the level is not between 0 and 1.
        """
        if not 0.0 < level < 1.0:
            raise ParameterError(f"Argument `level` must be between 0 and 1, but is {level:g}.")
        z = NormalDist().inv_cdf(0.5 + 0.5 * level)
        root = self._root()
        outputs: list[Numbers] = []
        spreads: list[Numbers] = []
        engine, theta = self.chain.engine, self.chain.theta
        start = None if state is None else ChainStart(state, np.zeros((len(state), len(theta))))
        for chunk in engine.sensitivities(theta, record.inputs, start):
            slopes = chunk.slopes[:, :, chunk.slopes.shape[2] - len(theta) :]
            outputs.append(chunk.outputs)
            spreads.append(np.sum((slopes @ root) ** 2, axis=2))
        variance = np.concatenate(spreads)
        return OutputBand(np.concatenate(outputs), z * np.sqrt(variance), z * np.sqrt(variance + self.residual**2))

    def draws(self, count: int, seed: int = 0) -> list[Chain]:
        """Return chains with free numbers drawn from a normal distribution with covariance C.

        Undetermined directions keep their values.
        """
        rng = np.random.default_rng(seed)
        root = self._root()
        moves = rng.standard_normal((count, root.shape[1])) @ root.T
        return [self.chain.with_theta(self.chain.theta + move) for move in moves]

    def _root(self) -> Numbers:
        """Return R with R Rᵀ = C."""
        values, vectors = np.linalg.eigh(self.covariance)
        positive = values > 1e-15 * max(float(values[-1]), 0.0) if len(values) else values > 0.0
        return vectors[:, positive] * np.sqrt(values[positive])


def estimate_chain_uncertainty(
    chain: Chain, squares: ResidualSquares, blocks: Sequence[int] | int | None = None, states: Numbers | None = None
) -> ChainUncertainty:
    """Return the covariance of a chain at the minimum of a sum of squares, such as `estimate.squares()`.

    Args:
        chain: the chain.
        squares: minimised sum of squares.
        blocks: block length in samples, for all records or for each; default: three correlation times. 1 means
            independent residuals.
        states: estimated initial states, in the order of `squares`; default: the steady states.

    Raises:
        DataError: no sample counts, or a residual is not finite.
        ParameterError: a block is shorter than a sample, or the number of blocks does not fit.
    """
    theta = squares.extend_parameters(chain.theta) if states is None else np.concatenate([chain.theta, states])
    lengths = _choose_lengths(squares, theta, blocks)
    sums = sum_blocks(squares, theta, lengths)
    count = float(sums.counts.sum())
    p = len(chain.theta)
    if not count or not np.all(np.isfinite(sums.square)):
        raise DataError("The covariance of a model needs residuals that are finite.")
    inverted = invert_normal(sums.square, chain.names())
    freedom = max(count - (p - inverted.null.shape[1]), 1.0)
    spread = sums.blocks / max(sums.blocks - 1, 1) * count / freedom
    covariance = spread * inverted.matrix @ sums.middle @ inverted.matrix
    covariance = 0.5 * (covariance + covariance.T)
    white = float(sums.squares.sum()) / freedom * inverted.matrix
    return ChainUncertainty(
        chain,
        covariance,
        inverted.null,
        inverted.scale,
        inverted.flat,
        _find_residual_deviation(squares, sums),
        lengths,
        inverted.condition,
        _find_ratio(covariance, white),
    )


def measure_coverage(band: OutputBand, record: Sampled, skip: int = 0) -> Numbers:
    """Return the fraction of the measurements within the band, for every output.

    Raises:
        DataError: an output has no counted measurement.
    """
    y = record.outputs[skip:]
    finite = np.isfinite(y)
    if not finite.any(axis=0).all():
        raise DataError(f"Record `{record.name}` has an output without measurements.")
    inside = np.abs(y - band.outputs[skip:]) <= band.measured[skip:]
    return np.sum(inside & finite, axis=0) / np.sum(finite, axis=0)


def _choose_lengths(squares: ResidualSquares, theta: Numbers, blocks: Sequence[int] | int | None) -> tuple[int, ...]:
    if blocks is None:
        return tuple(block_lengths(squares, theta))
    lengths = (blocks,) * len(squares.aims) if isinstance(blocks, int) else tuple(blocks)
    if len(lengths) != len(squares.aims) or min(lengths) < 1:
        raise ParameterError(
            f"Blocks must be of at least 1 sample, for each of {len(squares.aims)} records, but are {blocks}."
        )
    return lengths


def _find_residual_deviation(squares: ResidualSquares, sums: Sums) -> Numbers:
    """Return the standard deviation of the residuals of every output, without records of one sample."""
    long = np.array([len(aim.record) > 1 for aim in squares.aims])
    weights = np.array([aim.scale() for aim in squares.aims])
    total = np.sum((sums.squares / weights**2)[long], axis=0)
    number_of = np.maximum(np.sum(sums.counts[long], axis=0), 1.0)
    return np.sqrt(total / number_of)


def _find_ratio(covariance: Numbers, white: Numbers) -> float:
    """Return the root of the mean ratio of the variances."""
    coloured, plain = np.diag(covariance), np.diag(white)
    positive = plain > 0.0
    return float(np.sqrt(np.mean(coloured[positive] / plain[positive]))) if positive.any() else 1.0
