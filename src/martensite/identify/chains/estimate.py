"""Estimating a chain from records: many starts, the best refined at the full rate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

from martensite.errors import InputError, SolveError
from martensite.identify.blocks.base import AbstractBlock, Numbers
from martensite.identify.chains.chain import Chain, untrained
from martensite.identify.chains.levenberg import Found, minimise
from martensite.identify.chains.residuals import Aim, Squares
from martensite.identify.chains.scores import fit_percent
from martensite.identify.chains.starts import aligned, drawn
from martensite.identify.chains.written import parse_chain
from martensite.signals.sampled import Sampled

COARSE = 5000
"""Samples per record to which first searches thin long records."""
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
    made = parse_chain(blocks) if isinstance(blocks, str) else tuple(blocks)
    chain = untrained(made, max(records, key=len))
    tell = watch or (lambda text, share: None)
    first = _searched(chain, records, options, tell)
    ends: list[tuple[float, Found]] = []
    for k, theta in enumerate(first[: max(options.refined, 1)]):
        found = refine(chain.with_theta(theta[1]), records, options)
        ends.append((_fit(chain.with_theta(found.theta[: len(theta[1])]), records), found))
        tell(f"refined {k + 1}", 0.5 + 0.5 * (k + 1) / min(options.refined, len(first)))
    ends.sort(key=lambda end: end[1].value)
    if not ends or not np.isfinite(ends[0][1].value):
        raise SolveError(
            f"No search for `{chain.text()}` gave a model that can be simulated; try more "
            "starts, fewer units or a lower order."
        )
    best = ends[0][1]
    count = len(chain.theta)
    return Estimate(
        chain.with_theta(best.theta[:count]), records, tuple(aims(records, options)), best,
        tuple(sorted((fit for fit, _ in ends), reverse=True)),
        tuple(value for value, _ in first), options,
    )  # fmt: skip


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
            raise InputError(
                f"Records `{first.name}` and `{record.name}` have different inputs or outputs."
            )


def aims(records: Sequence[Sampled], options: Options) -> list[Aim]:
    """What is fitted: the records, on one scale, and what they say of rest."""
    spread = np.nanstd(np.concatenate([r.outputs for r in records]), axis=0)
    weights = 1.0 / np.where(spread > 0.0, spread, 1.0)
    found = [Aim(r, options.skip, weights, options.start) for r in records]
    if options.anchor > 0.0:
        for record in records:
            heavy = weights * np.sqrt(options.anchor * len(record))
            found.append(Aim(record.rows(0, 1, f"{record.name} at rest"), 0, heavy))
    return found


def refine(chain: Chain, records: Sequence[Sampled], options: Options) -> Found:
    """The nearest minimum from the numbers of a chain, at the full rate."""
    squares = Squares(chain.engine, aims(records, options), options.ridge, chain.theta)
    return minimise(squares, squares.extended(chain.theta), options.iterations)


def _searched(
    chain: Chain, records: Sequence[Sampled], options: Options,
    tell: Callable[[str, float], None],
) -> list[tuple[float, Numbers]]:  # fmt: skip
    """Ends of searches on thinned records, best first."""
    thin = [coarse(record) for record in records]
    slow = replace(chain, interval=thin[0].interval)
    rng = np.random.default_rng(options.seed)
    begins = [chain.theta]
    begins += [drawn(chain, rng, records[0]) for _ in range(options.starts - 1)]
    squares = Squares(slow.engine, aims(thin, options), options.ridge)

    def search(theta: Numbers) -> tuple[float, Numbers]:
        begun = aligned(slow.with_theta(theta), thin)
        found = minimise(squares, squares.extended(begun.theta), max(options.iterations // 2, 1))
        return found.value / squares.count, found.theta[: len(theta)]

    ends: list[tuple[float, Numbers]] = []
    with ThreadPoolExecutor(options.threads) as pool:
        for k, end in enumerate(pool.map(search, begins)):
            ends.append(end)
            tell(f"start {k + 1} of {len(begins)}", 0.5 * (k + 1) / len(begins))
    return sorted((end for end in ends if np.isfinite(end[0])), key=lambda end: end[0])


def coarse(record: Sampled, most: int = COARSE) -> Sampled:
    """A thinner record: inputs at the first of some samples, outputs averaged over them."""
    factor = len(record) // most
    if factor < 2:
        return record
    count = len(record) // factor
    blocks = record.outputs[: count * factor].reshape(count, factor, -1)
    return replace(
        record, interval=record.interval * factor,
        inputs=record.inputs[: count * factor : factor], outputs=blocks.mean(axis=1),
    )  # fmt: skip


def _fit(chain: Chain, records: Sequence[Sampled]) -> float:
    """Mean fit [%] over records and outputs."""
    return float(np.mean([fit_percent(r.outputs, chain.simulate(r)) for r in records]))
