"""Estimating a chain from records: many starts, the best refined at the full rate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

from martensite.errors import InputError, SolveError
from martensite.identify.blocks.base import AbstractBlock, Numbers
from martensite.identify.chains.chain import Chain, untrained
from martensite.identify.chains.checks import check_enough, check_informative, check_records
from martensite.identify.chains.informed import PART, begins, thinnest
from martensite.identify.chains.levenberg import Found, minimise
from martensite.identify.chains.noise_model import noise_model
from martensite.identify.chains.residuals import Aim, Squares
from martensite.identify.chains.scored import free_run
from martensite.identify.chains.scores import fit_percent
from martensite.identify.chains.written import parse_chain
from martensite.signals.sampling.resampling import resampled
from martensite.signals.sampling.sampled import Sampled

COARSE = 5000
"""Samples per record to which first searches thin long records."""
LEAST = 20
"""Samples that a record keeps at least when it is thinned."""
INTERRUPTED = "interrupted"
"""What `watch` is told when Ctrl-C ended a search early; the best so far is kept."""
TURNS = 3
"""How often noise model and chain follow each other."""
ALIKE = 0.1
"""Points of fit within which two searches found the same."""


@dataclass(frozen=True)
class Options:
    """How a chain is estimated."""

    starts: int = 12
    """Searches from different starts; 1 takes the plainest start only."""
    refined: int = 3
    """How many of the best go on at the full rate."""
    iterations: int = 100
    """Most steps of a search at the full rate; first searches take half."""
    seed: int = 0
    skip: int = 0
    """Samples at the start of every record that do not count."""
    start: str = "rest"
    """State at the first sample: rest, zero, estimate."""
    anchor: float = 0.0
    """Weight of the first known outputs as those at rest, in shares of all samples."""
    ridge: float = 0.0
    """Pull towards the start of the last search, per sample."""
    sigma: tuple[float, ...] = ()
    """Size of a usual residual of every output, such as 1 K and 0.1 mm; by default its spread."""
    priors: bool = True
    """Whether what blocks expect of their free numbers counts; see `AbstractBlock.priors`."""
    noise: int = 0
    """Order of the noise model; 0 minimises the simulation error, else the prediction error."""
    threads: int = 2


@dataclass(frozen=True, eq=False)
class Estimate:
    """A chain that was estimated, and how."""

    chain: Chain
    records: tuple[Sampled, ...]
    aims: tuple[Aim, ...]
    found: Found
    fits: tuple[float, ...]
    """Fit [%] at the ends of all refined searches, best first."""
    coarse: tuple[float, ...]
    """Relative costs at the ends of the first searches, best first."""
    options: Options = field(default_factory=Options)

    @property
    def agreeing(self) -> int:
        """How many refined searches ended within 0.1 point of the best."""
        return sum(fit >= self.fits[0] - ALIKE for fit in self.fits)

    def squares(self) -> Squares:
        """The sum of squares that was minimised."""
        return Squares(self.chain.engine, self.aims)


def estimate(
    blocks: str | Sequence[AbstractBlock],
    records: Sampled | Sequence[Sampled],
    options: Options | None = None,
    watch: Callable[[str, float], None] | None = None,
) -> Estimate:
    """A chain of blocks that reproduces the outputs of records in free run.

    Args:
        blocks: the structure, as text such as `poly2 | oe(3,3,1) | pwl10`, or its blocks.
        records: one or several, of one sample time.
        options: how it is searched.
        watch: called with a sentence and the share that is done.

    Raises:
        InputError: records or structure do not fit.
        SolveError: no search gave a model that can be simulated.
    """
    options = options or Options()
    records = (records,) if isinstance(records, Sampled) else tuple(records)
    check_records(records)
    check_informative(records, options.skip, options.start)
    made = parse_chain(blocks) if isinstance(blocks, str) else tuple(blocks)
    _check_signals(made, records[0])
    chain = untrained(made, max(records, key=len))
    check_enough(chain, records, options.skip)
    tell = watch or (lambda text, share: None)
    first = _searched(chain, records, options, tell)
    ends: list[tuple[float, Found, Chain]] = []
    for k, (_, begun) in enumerate(first[: max(options.refined, 1)]):
        try:
            found = refine(begun, records, options)
        except KeyboardInterrupt:
            if not ends:
                raise
            tell(INTERRUPTED, 1.0)
            break
        end = begun.with_theta(found.theta[: len(begun.theta)])
        ends.append((_fit(end, records, options), found, end))
        tell(f"refined {k + 1}", 0.5 + 0.5 * (k + 1) / min(options.refined, len(first)))
    ends.sort(key=lambda end: end[1].value)
    if not ends or not np.isfinite(ends[0][1].value):
        raise SolveError(
            f"No search for `{chain.text()}` gave a model that can be simulated; try more "
            "starts, fewer units or a lower order."
        )
    _, best, chain = ends[0]
    wanted = tuple(aims(records, options))
    if options.noise:
        best, wanted = whitened(chain, best, wanted, options)
        chain = chain.with_theta(best.theta[: len(chain.theta)])
    return Estimate(
        chain, records, wanted, best, tuple(sorted((fit for fit, _, _ in ends), reverse=True)),
        tuple(value for value, _ in first), options,
    )  # fmt: skip


def _check_signals(blocks: Sequence[AbstractBlock], record: Sampled) -> None:
    """Raise `InputError` unless blocks and record have as many inputs and outputs."""
    sides = (
        ("takes", "inputs", blocks[0], blocks[0].inputs, record.input_names),
        ("gives", "outputs", blocks[-1], blocks[-1].outputs, record.output_names),
    )
    for verb, word, block, count, names in sides:
        if count != len(names):
            raise InputError(
                f"Block `{block.text()}` {verb} {count} {word}, but record `{record.name}` has "
                f"{len(names)}: {', '.join(names)}."
            )


def aims(records: Sequence[Sampled], options: Options) -> list[Aim]:
    """What is fitted: the records, on one scale, and what they say of rest."""
    weights = 1.0 / _spread(records, options)
    found = [Aim(r, options.skip, weights, options.start) for r in records]
    if options.anchor > 0.0:
        for record in records:
            heavy = weights * np.sqrt(options.anchor * len(record))
            found.append(Aim(at_rest(record), 0, heavy))
    return found


def at_rest(record: Sampled) -> Sampled:
    """One sample: the first inputs, and the mean of the outputs until an input changes."""
    moved = np.any(record.inputs != record.inputs[0], axis=1)
    count = int(np.argmax(moved)) if moved.any() else len(record)
    before = record.outputs[:count]
    known = np.isfinite(before).sum(axis=0)
    levels = np.where(known > 0, np.nansum(before, axis=0) / np.maximum(known, 1), np.nan)
    first = record.rows(0, 1, f"{record.name} at rest")
    return first.with_outputs(levels[None, :])


def _spread(records: Sequence[Sampled], options: Options) -> Numbers:
    """What a residual of every output is measured in."""
    if not options.sigma:
        spread = np.nanstd(np.concatenate([r.outputs for r in records]), axis=0)
        return np.where(spread > 0.0, spread, 1.0)
    if len(options.sigma) != records[0].outputs.shape[1] or not min(options.sigma) > 0.0:
        raise InputError(
            f"`sigma` must hold a number above 0 for each of the {records[0].outputs.shape[1]} "
            f"outputs, but is {', '.join(f'{s:g}' for s in options.sigma)}."
        )
    return np.array(options.sigma)


def expected(chain: Chain, options: Options) -> tuple[Numbers, Numbers]:
    """Where θ is pulled, and the 1/σ of priors: to what blocks expect, else to where it is."""
    found = [block.priors() for block in chain.blocks]
    centres, weights = (np.concatenate([np.zeros(0), *part]) for part in zip(*found, strict=True))
    weights = weights * options.priors
    return np.where(weights > 0.0, centres, chain.theta), weights


def refine(chain: Chain, records: Sequence[Sampled], options: Options) -> Found:
    """The nearest minimum from the numbers of a chain, at the full rate."""
    squares = Squares(
        chain.engine, aims(records, options), options.ridge, *expected(chain, options)
    )
    return minimise(squares, squares.extended(chain.theta), options.iterations)


def whitened(
    chain: Chain, found: Found, wanted: Sequence[Aim], options: Options
) -> tuple[Found, tuple[Aim, ...]]:
    """The minimum of the prediction error: noise model and chain in turns, from a minimum."""
    aims_ = tuple(wanted)
    prior = expected(chain, options)
    for _ in range(TURNS):
        squares = Squares(chain.engine, aims_, options.ridge, *prior)
        left: list[Numbers] = []
        theta = found.theta[: len(chain.theta)]
        for aim, state in zip(aims_, squares.initial(found.theta), strict=True):
            computed = chain.with_theta(theta).simulate(aim.record, state)
            left.append(((aim.record.outputs - computed) * aim.scale())[aim.skip :])
        filter_ = noise_model(left, options.noise)
        # a record of one sample, such as that of rest, has no noise to be whitened
        aims_ = tuple(replace(a, whitening=filter_) if len(a.record) > 1 else a for a in aims_)
        squares = Squares(chain.engine, aims_, options.ridge, *prior)
        found = minimise(squares, found.theta, options.iterations)
    return found, aims_


def _searched(
    chain: Chain, records: Sequence[Sampled], options: Options,
    tell: Callable[[str, float], None],
) -> list[tuple[float, Chain]]:  # fmt: skip
    """Ends of searches on thinned records, best first."""
    thin = coarse(records)
    factor = thin[0].interval / records[0].interval
    slow = replace(chain, interval=thin[0].interval)
    own = replace(options, skip=round(options.skip / factor))
    rng = np.random.default_rng(options.seed)
    begun = begins(slow, thin, rng, options.starts)

    def search(one: Chain) -> tuple[float, Chain]:
        squares = Squares(one.engine, aims(thin, own), own.ridge, *expected(one, own))
        theta = squares.extended(one.theta)
        found = minimise(squares, theta, max(options.iterations // 2, 1))
        end = one.with_theta(found.theta[: len(one.theta)])
        return found.value / squares.count, replace(end, interval=chain.interval)

    ends: list[tuple[float, Chain]] = []
    with ThreadPoolExecutor(options.threads) as pool:
        found = pool.map(search, begun)
        try:
            for k, end in enumerate(found):
                ends.append(end)
                tell(f"start {k + 1} of {len(begun)}", 0.5 * (k + 1) / len(begun))
        except KeyboardInterrupt:  # go on with what there is
            pool.shutdown(wait=False, cancel_futures=True)
            if not ends:
                raise
            tell(INTERRUPTED, 0.5)
    return sorted((end for end in ends if np.isfinite(end[0])), key=lambda end: end[0])


def coarse(records: Sequence[Sampled], most: int = COARSE) -> list[Sampled]:
    """Thinner records of one sample time: means over some samples, of inputs and outputs alike.

    Where the outputs change too fast for that, only the first part of a record is taken.
    """
    factor = min(max(map(len, records)) // most, min(map(len, records)) // LEAST)
    if (kept := thinnest(records, factor)) < factor:
        factor, records = kept, [r.rows(0, PART * kept) for r in records]
    return [r if factor < 2 else resampled(r, ratio=float(factor)) for r in records]


def _fit(chain: Chain, records: Sequence[Sampled], options: Options) -> float:
    """Mean fit [%] over records and outputs."""
    runs = [(r.outputs, free_run(chain, r, options.start, options.skip)) for r in records]
    return float(np.mean([fit_percent(y, computed, options.skip) for y, computed in runs]))
