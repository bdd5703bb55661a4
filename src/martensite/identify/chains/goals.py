"""Options and goal of an estimation, checks of its records, and noise models.

The goal has the outputs of all records on one scale, anchors of steady outputs, and the priors of blocks. The noise
model is the whitening filter of coloured residuals, for the prediction error:

    L(q) v_t = e_t,   L = 1 + l_1 q^-1 + … + l_n q^-n

by autoregressive least squares over samples with n known predecessors. Noise model and chain are estimated in turns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from threading import Event

import numpy as np

from martensite.base.errors import DataError, InputError
from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares
from martensite.search.levenberg_marquardt import CostMinimum, minimise_cost
from martensite.signals.sampling.sampled import Sampled

AUTO = "auto"
"""Start that is tested for each record."""


@dataclass(frozen=True)
class Options:
    """Options of the estimation of a chain."""

    starts: int = 12
    refined: int = 3
    """Number of best searches that continue with more samples."""
    iterations: int = 100
    """Largest number of their steps; first searches have half, the last one a quarter."""
    seed: int = 0
    skip: int = 0
    """Samples at the start of every record that do not count."""
    start: str = "rest"
    """State at the first sample: rest, zero, estimate, or auto, which tests every record for a steady start."""
    anchor: float = 0.0
    """Weight of the first known outputs as steady outputs, over all samples, for records with a steady start."""
    ridge: float | None = None
    """Pull towards the start of the last search, per sample; default: only for short records, cross-validated."""
    sigma: tuple[float, ...] = ()
    """Standard deviation of the residuals of every output, such as 1 K and 0.1 mm; default: its spread."""
    priors: bool = True
    """True to use the priors of blocks (`AbstractBlock.priors`)."""
    noise: int = 0
    """Order of the noise model; 0 minimises the simulation error, else the prediction error."""
    threads: int = 2
    begin: tuple[Chain, ...] = ()
    """Further chains to start from, such as an earlier estimate; blocks may be simpler."""


def check_records(records: Sequence[Sampled]) -> None:
    """Raise `InputError` unless the records can be fitted together."""
    if not records:
        raise InputError("An estimation needs at least one record.")
    first = records[0]
    for record in records[1:]:
        if abs(record.interval / first.interval - 1.0) > 1e-6:
            raise InputError(
                f"Records fitted together need one sample time, but `{first.name}` has "
                f"{first.interval:.6g} s and `{record.name}` {record.interval:.6g} s."
            )
        if (record.input_names, record.output_names) != (first.input_names, first.output_names):
            raise InputError(f"Records `{first.name}` and `{record.name}` have different inputs or outputs.")


def check_informative(records: Sequence[Sampled], skip: int, start: str) -> None:
    """Raise `InputError` for an empty output, or a constant input unless initial states are estimated."""
    first = records[0]
    u = np.concatenate([record.inputs for record in records])
    y = np.concatenate([record.outputs[skip:] for record in records])
    for name, column in zip(first.input_names, u.T, strict=True):
        if start != "estimate" and np.ptp(column) == 0.0:
            raise InputError(
                f"Input `{name}` is {column[0]:g} throughout; nothing can be found from an input that never changes."
            )
    for name, column in zip(first.output_names, y.T, strict=True):
        finite = column[np.isfinite(column)]
        if not len(finite):
            raise InputError(f"Output `{name}` has no known samples that count.")
        if np.ptp(finite) == 0.0:
            raise InputError(f"Output `{name}` is {finite[0]:g} throughout; there is nothing to fit.")


def check_enough(chain: Chain, records: Sequence[Sampled], skip: int) -> None:
    """Raise `InputError` if there are fewer known outputs than free numbers."""
    count = sum(int(np.isfinite(r.outputs[skip:]).sum()) for r in records)
    if count < len(chain.theta):
        raise InputError(
            f"`{chain.text()}` has {len(chain.theta)} free numbers, but the records hold {count} "
            "known outputs that count; take longer records or a smaller structure."
        )


@dataclass(frozen=True, eq=False)
class Goal:
    """Cost, initial states, and end of searches."""

    options: Options
    starts: tuple[str, ...]
    """State at the first sample of every record: rest, zero, estimate."""
    halt: Event = field(default_factory=Event)
    """If set, searches end with their present result."""
    strength: float = 0.0
    """Strength of the pull towards `bases`, relative to the effect on the outputs."""
    bases: tuple[Chain, ...] = ()
    """Simplest and linear chain, for short records."""

    @classmethod
    def begin(cls, options: Options, records: Sequence[Sampled]) -> Goal:
        """Return the initial goal, with steady starts where they are to be tested."""
        return cls(options, ("rest" if options.start == AUTO else options.start,) * len(records))

    def squares(self, chain: Chain, records: Sequence[Sampled]) -> ResidualSquares:
        """Return the sum of squares of a search from the numbers of a chain."""
        expected, weights = find_expected(chain, self.options)
        if self.strength:
            base = next((one for one in self.bases if _has_same_blocks(one, chain)), chain)
            bare = self.bare_squares(base, records)
            moved = np.diag(bare.normal(bare.extend_parameters(base.theta)).hessian)[: len(chain.theta)]
            expected = np.where(weights > 0.0, expected, base.theta)
            weights = np.sqrt(weights**2 + self.strength * np.maximum(moved, _find_floor(moved)))
        aims = build_aims(records, self.options, self.starts)
        return ResidualSquares(chain.engine, aims, self.options.ridge or 0.0, expected, weights, self.halt)

    def bare_squares(self, chain: Chain, records: Sequence[Sampled]) -> ResidualSquares:
        """Return the sum of squares of the records alone."""
        aims = build_aims(records, replace(self.options, anchor=0.0), self.starts)
        return ResidualSquares(chain.engine, aims, halt=self.halt)


def _has_same_blocks(one: Chain, other: Chain) -> bool:
    return [b.fixed_values() for b in one.blocks] == [b.fixed_values() for b in other.blocks]


def _find_floor(moved: Numbers) -> float:
    positive = moved[moved > 0.0]
    return 1e-3 * float(np.median(positive)) if len(positive) else 0.0


def build_aims(
    records: Sequence[Sampled], options: Options, starts: Sequence[str] | None = None
) -> list[RecordResidual]:
    """Return the residuals of the records on one scale, and the anchors of records with a steady start."""
    weights = 1.0 / _find_spread(records, options)
    starts = starts or [options.start] * len(records)
    aims = [RecordResidual(r, options.skip, weights, s) for r, s in zip(records, starts, strict=True)]
    if options.anchor > 0.0:
        for record, start in zip(records, starts, strict=True):
            if start == "rest" or options.start != AUTO:
                heavy = weights * np.sqrt(options.anchor * len(record))
                aims.append(RecordResidual(at_rest(record), 0, heavy))
    return aims


def at_rest(record: Sampled) -> Sampled:
    """Return one sample: the first inputs, and the mean of the outputs until an input changes."""
    moved = np.any(record.inputs != record.inputs[0], axis=1)
    count = int(np.argmax(moved)) if moved.any() else len(record)
    before = record.outputs[:count]
    counts = np.isfinite(before).sum(axis=0)
    levels = np.where(counts > 0, np.nansum(before, axis=0) / np.maximum(counts, 1), np.nan)
    first = record.rows(0, 1, f"{record.name} at rest")
    return first.with_outputs(levels[None, :])


def _find_spread(records: Sequence[Sampled], options: Options) -> Numbers:
    if not options.sigma:
        spread = np.nanstd(np.concatenate([r.outputs for r in records]), axis=0)
        return np.where(spread > 0.0, spread, 1.0)
    if len(options.sigma) != records[0].outputs.shape[1] or not min(options.sigma) > 0.0:
        raise InputError(
            f"`sigma` must hold a number above 0 for each of the {records[0].outputs.shape[1]} "
            f"outputs, but is {', '.join(f'{s:g}' for s in options.sigma)}."
        )
    return np.array(options.sigma)


def find_expected(chain: Chain, options: Options) -> tuple[Numbers, Numbers]:
    """Return the centres of the pull on θ and 1/σ of the priors; without a prior the present θ."""
    priors = [block.priors() for block in chain.blocks]
    centres, weights = (np.concatenate([np.zeros(0), *part]) for part in zip(*priors, strict=True))
    weights = weights * options.priors
    return np.where(weights > 0.0, centres, chain.theta), weights


NOISE_TURNS = 3


def noise_model(residuals: Sequence[Numbers], order: int) -> Numbers:
    """Return the coefficients 1, l_1 … l_n of L(q).

    Args:
        residuals: residuals of records, shape (samples, outputs), NaN where unknown.
        order: n.

    Raises:
        DataError: too few successive samples are known.
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
    chain: Chain, minimum: CostMinimum, wanted: Sequence[RecordResidual], options: Options
) -> tuple[CostMinimum, tuple[RecordResidual, ...]]:
    """Return the minimum of the prediction error, with noise model and chain in turns."""
    aims = tuple(wanted)
    prior = find_expected(chain, options)
    for _ in range(NOISE_TURNS):
        squares = ResidualSquares(chain.engine, aims, options.ridge or 0.0, *prior)
        residuals: list[Numbers] = []
        theta = minimum.theta[: len(chain.theta)]
        for aim, state in zip(aims, squares.initial(minimum.theta), strict=True):
            computed = chain.with_theta(theta).simulate(aim.record, state)
            residuals.append(((aim.record.outputs - computed) * aim.scale())[aim.skip :])
        whitening = noise_model(residuals, options.noise)
        # a record of one sample has no noise
        aims = tuple(replace(a, whitening=whitening) if len(a.record) > 1 else a for a in aims)
        squares = ResidualSquares(chain.engine, aims, options.ridge or 0.0, *prior)
        minimum = minimise_cost(squares, minimum.theta, options.iterations)
    return minimum, aims
