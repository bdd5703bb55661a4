"""Estimating a chain from records: many starts, the best of them refined with more samples.

First searches run on about 5000 samples per record, the best few go on with 25 000, and the best
of these ends at the full rate. Records without so many samples skip a level.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from martensite.base.errors import InputError, SolveError
from martensite.identify.blocks.base import AbstractBlock
from martensite.identify.chains.chain import Chain, build_untrained
from martensite.identify.chains.chain_text import parse_chain
from martensite.identify.chains.decimation import MIDDLE, coarsen_records
from martensite.identify.chains.goals import Options as Options
from martensite.identify.chains.goals import (
    build_aims,
    check_enough,
    check_informative,
    check_records,
    squares_of,
    whiten_chain,
)
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares, settle_states
from martensite.identify.chains.scores import fit_percent, free_run
from martensite.identify.chains.starts import begin_from_chain, list_informed_starts
from martensite.search.levenberg_marquardt import Found, minimise_cost
from martensite.signals.sampling.sampled import Sampled

INTERRUPTED = "interrupted"
"""What `watch` is told when Ctrl-C ended a search early; the best so far is kept."""
ALIKE = 0.1
"""Points of fit within which two searches found the same."""
Tell = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class ChainEstimate:
    """A chain that was estimated, and how."""

    chain: Chain
    records: tuple[Sampled, ...]
    aims: tuple[RecordResidual, ...]
    found: Found
    """Where the last search ended, which ran at the full rate."""
    fits: tuple[float, ...]
    """Fit [%] at the ends of all refined searches, best first; of long records over the thinner
    ones that these ran on."""
    coarse: tuple[float, ...]
    """Relative costs at the ends of the first searches, best first."""
    options: Options = field(default_factory=Options)

    @property
    def agreeing(self) -> int:
        """How many refined searches ended within 0.1 point of the best."""
        return sum(fit >= self.fits[0] - ALIKE for fit in self.fits)

    def squares(self) -> ResidualSquares:
        """The sum of squares that was minimised."""
        return ResidualSquares(self.chain.engine, self.aims)


class SearchEnd(NamedTuple):
    """Where a search ended."""

    cost: float
    """Sum of squares per known output, each over its scale."""
    found: Found
    chain: Chain


def estimate_chain(
    blocks: str | Sequence[AbstractBlock],
    records: Sampled | Sequence[Sampled],
    options: Options | None = None,
    watch: Tell | None = None,
) -> ChainEstimate:
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
    chain = build_untrained(made, max(records, key=len))
    check_enough(chain, records, options.skip)
    tell = watch or (lambda text, share: None)
    thin, middle = coarsen_records(records), coarsen_records(records, MIDDLE)
    first = _search_thin(chain, thin, _thin_options(options, thin, records), tell)
    best = [end.chain for end in first[: max(options.refined, 1)]]
    own = _thin_options(options, middle, records)
    refined = _refine_all(best, middle, own, _tell_searches(tell, "refined", 0.5, 0.9))
    if not refined:
        raise SolveError(
            f"No search for `{chain.text()}` gave a model that can be simulated; try more "
            "starts, fewer units or a lower order."
        )
    last = _finish_search(refined, middle, records, options)
    tell("full rate", 1.0)
    wanted = tuple(build_aims(records, options))
    found, chain = last.found, last.chain
    if options.noise:
        found, wanted = whiten_chain(chain, found, wanted, options)
        chain = chain.with_theta(found.theta[: len(chain.theta)])
    fits = (_compute_fit(end.chain, middle, own) for end in refined)
    return ChainEstimate(
        chain, records, wanted, found, tuple(sorted(fits, reverse=True)), tuple(end.cost for end in first), options
    )


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


def refine_chain(chain: Chain, records: Sequence[Sampled], options: Options) -> Found:
    """The nearest minimum from the numbers of a chain, at the full rate."""
    squares = squares_of(chain, records, options)
    return minimise_cost(squares, squares.extend_parameters(chain.theta), options.iterations)


def _thin_options(options: Options, thin: Sequence[Sampled], records: Sequence[Sampled]) -> Options:
    """The options for thinner records: as long a start that does not count."""
    return replace(options, skip=round(options.skip * records[0].interval / thin[0].interval))


def _search_thin(chain: Chain, records: Sequence[Sampled], options: Options, tell: Tell) -> list[SearchEnd]:
    """Ends of first searches over thin records, from given chains and from others."""
    slow = replace(chain, interval=records[0].interval)
    given = [begin_from_chain(slow, one, records) for one in options.begin]
    rng = np.random.default_rng(options.seed)
    begin = [*given, *list_informed_starts(slow, records, rng, options.starts, options.start)]
    half = replace(options, iterations=max(options.iterations // 2, 1))
    return _refine_all(begin, records, half, _tell_searches(tell, "start", 0.0, 0.5))


def _tell_searches(tell: Tell, word: str, low: float, high: float) -> Callable[[int, int], None]:
    """What tells how many searches have ended of how many; none is an interruption."""

    def told(count: int, of: int) -> None:
        if count:
            tell(f"{word} {count} of {of}", low + (high - low) * count / of)
        else:
            tell(INTERRUPTED, high)

    return told


def _refine_all(
    chains: Sequence[Chain], records: Sequence[Sampled], options: Options, told: Callable[[int, int], None]
) -> list[SearchEnd]:
    """Ends of searches from chains over records, best first; Ctrl-C keeps what there is."""
    ends: list[SearchEnd] = []
    with ThreadPoolExecutor(options.threads) as pool:
        found = pool.map(lambda chain: _refine_one(chain, records, options), chains)
        try:
            for end in found:
                ends.append(end)
                told(len(ends), len(chains))
        except KeyboardInterrupt:  # go on with what there is
            pool.shutdown(wait=False, cancel_futures=True)
            if not ends:
                raise
            told(0, len(chains))
    return sorted((end for end in ends if np.isfinite(end.cost)), key=lambda end: end.cost)


def _refine_one(chain: Chain, records: Sequence[Sampled], options: Options) -> SearchEnd:
    """The nearest minimum over records of any sample time."""
    chain = replace(chain, interval=records[0].interval)
    found = refine_chain(chain, records, options)
    end = chain.with_theta(found.theta[: len(chain.theta)])
    known = sum(int(np.isfinite(r.outputs[options.skip :]).sum()) for r in records)
    return SearchEnd(found.value / known, found, end)


def _finish_search(
    refined: Sequence[SearchEnd], middle: Sequence[Sampled], records: Sequence[Sampled], options: Options
) -> SearchEnd:
    """The end of the best search at the full rate.

    Raises:
        SolveError: no model that was found on thinner records can be simulated there.
    """
    if all(a is b for a, b in zip(middle, records, strict=True)):
        return refined[0]
    full = [replace(end.chain, interval=records[0].interval) for end in refined]
    best = min(full, key=lambda chain: _compute_cost(chain, records, options))
    last = _refine_one(best, records, replace(options, iterations=max(options.iterations // 4, 1)))
    if not np.isfinite(last.cost):
        raise SolveError(
            f"`{best.text()}` fits thinner records, but cannot be simulated at the full rate; "
            "thin the records or lower the order."
        )
    return last


def _compute_cost(chain: Chain, records: Sequence[Sampled], options: Options) -> float:
    """What a search minimises, with the best initial states where these are estimated."""
    squares = squares_of(chain, records, options)
    if options.start != "estimate":
        return squares.value(chain.theta)
    return settle_states(squares, chain.theta, 10).value


def _compute_fit(chain: Chain, records: Sequence[Sampled], options: Options) -> float:
    """Mean fit [%] over records and outputs."""
    runs = [(r.outputs, free_run(chain, r, options.start, options.skip)) for r in records]
    return float(np.mean([fit_percent(y, computed, options.skip) for y, computed in runs]))
