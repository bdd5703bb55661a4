"""Estimating a chain from records: many starts, the best of them refined with more samples.

First searches run on about 5000 samples per record, the best few go on with 25 000, and the best
of these ends at the full rate. Records without so many samples skip a level.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from threading import Event
from typing import NamedTuple

import numpy as np

from martensite.base.errors import InputError, SolveError
from martensite.base.interrupts import accept_interrupt
from martensite.identify.blocks.base import AbstractBlock
from martensite.identify.chains.chain import Chain, build_untrained
from martensite.identify.chains.chain_text import parse_chain
from martensite.identify.chains.decimation import MIDDLE, coarsen_records
from martensite.identify.chains.doubts import describe_copies, describe_exchange, describe_motion
from martensite.identify.chains.fences import fence_chain
from martensite.identify.chains.goals import (
    AUTO,
    Goal,
    build_aims,
    check_enough,
    check_informative,
    check_records,
    whiten_chain,
)
from martensite.identify.chains.goals import Options as Options
from martensite.identify.chains.record_starts import find_start, keep_starts, shows_rest
from martensite.identify.chains.residuals import HaltedSearchError, RecordResidual, ResidualSquares, settle_states
from martensite.identify.chains.scores import fit_percent
from martensite.identify.chains.starts import begin_from_chain, list_informed_starts
from martensite.search.levenberg_marquardt import Found, Numbers, minimise_cost
from martensite.signals.sampling.sampled import Sampled

INTERRUPTED = "interrupted"
"""Message to `watch` if Ctrl-C ended a search early; the best chain so far is kept."""
ALIKE = 0.1
"""Points of fit within which two searches found the same."""
SHORT = 30
"""Known outputs per free number below which records are short."""
STRENGTHS = (1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-6)
"""Pulls that are tried on short records, over what moves the outputs."""
THIRDS = 3
PROBES = 3
"""Best searches from rest that are gone on with from other initial states."""
DOUBT = 0.9
"""Squared error with other initial states, over that from rest, below which a record does not begin at rest."""
Tell = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class ChainEstimate:
    """A chain that was estimated, and how."""

    chain: Chain
    records: tuple[Sampled, ...]
    aims: tuple[RecordResidual, ...]
    found: Found
    """End of the last search, at the full sample rate."""
    fits: tuple[float, ...]
    """Fit [%] at the ends of all refined searches, best first; of long records over the thinner
    ones that these ran on."""
    coarse: tuple[float, ...]
    """Relative costs at the ends of the first searches, best first."""
    options: Options = field(default_factory=Options)
    complete: bool = True
    """False if it was interrupted: the best until then, which no further search has refined."""
    remarks: tuple[str, ...] = ()
    """Doubts, one sentence each."""

    @property
    def agreeing(self) -> int:
        """Return the number of refined searches that ended within 0.1 point of the best."""
        return sum(fit >= self.fits[0] - ALIKE for fit in self.fits)

    def squares(self) -> ResidualSquares:
        """Return the sum of squares that was minimised."""
        return ResidualSquares(self.chain.engine, self.aims)


class SearchEnd(NamedTuple):
    """End of a search."""

    cost: float
    """Sum of squares per known output, each over its scale."""
    found: Found
    chain: Chain


def estimate_chain(
    blocks: str | Sequence[AbstractBlock],
    records: Sampled | Sequence[Sampled],
    options: Options | None = None,
    watch: Tell | None = None,
    halt: Event | None = None,
) -> ChainEstimate:
    """Return a chain of blocks that reproduces the outputs of records in free run.

    Args:
        blocks: the structure, as text such as `poly2 | oe(3,3,1) | pwl10`, or its blocks.
        records: one or several, of one sample time.
        options: how it is searched.
        watch: called with a sentence and the share that is done.
        halt: once it is set, for instance by a clock, searches end as after Ctrl-C.

    Raises:
        InputError: records or structure do not fit.
        SolveError: no search gave a model that can be simulated.
        KeyboardInterrupt: it was halted or interrupted before there was a model.
    """
    options = options or Options()
    records = (records,) if isinstance(records, Sampled) else tuple(records)
    check_records(records)
    check_informative(records, options.skip, options.start)
    made = parse_chain(blocks) if isinstance(blocks, str) else tuple(blocks)
    _check_signals(made, records[0])
    chain = build_untrained(made, max(records, key=len))
    check_enough(chain, records, options.skip)
    made = _Estimation(chain, records, options, watch or (lambda text, share: None))
    made.goal = replace(made.goal, halt=halt or made.goal.halt)
    try:
        return made.run()
    except HaltedSearchError:  # between two searches
        raise KeyboardInterrupt from None


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
    """Return the nearest minimum from the numbers of a chain, at the full rate."""
    squares = Goal.begin(options, records).squares(chain, records)
    return minimise_cost(squares, squares.extend_parameters(chain.theta), options.iterations)


class _Estimation:
    """The searches of one estimation; what is best so far stays when one is interrupted."""

    def __init__(self, chain: Chain, records: tuple[Sampled, ...], options: Options, tell: Tell) -> None:
        self.chain, self.records, self.options, self.tell = chain, records, options, tell
        self.thin, self.middle = coarsen_records(records), coarsen_records(records, MIDDLE)
        self.goal = Goal.begin(options, records)
        self.remarks: list[str] = []

    def run(self) -> ChainEstimate:
        """Return many starts on thin records, the best of them refined, the best of these at the full rate."""
        if self.options.ridge is None:
            self._guard_short()
        first = self._search_starts()
        refined, level = first, self.thin
        if not self.goal.halt.is_set():
            try:
                best = [end.chain for end in first[: max(self.options.refined, 1)]]
                own = self._goal_for(self.middle)
                refined, level = _refine_all(best, self.middle, own, self._share("refined", 0.5, 0.9)), self.middle
            except KeyboardInterrupt:
                self._halt()
        if not refined:
            raise SolveError(
                f"No search for `{self.chain.text()}` gave a model that can be simulated; try more "
                "starts, fewer units or a lower order."
            )
        last = self._finish(refined, level)
        self.tell("full rate", 1.0)
        fits = [_compute_fit(end, level, self._goal_for(level)) for end in refined]
        return self._describe(last, sorted(fits, reverse=True), [end.cost for end in first])

    def _guard_short(self) -> None:
        """Pull the parameters towards a linear model if the records are short for their number."""
        known = sum(int(np.isfinite(record.outputs[self.options.skip :]).sum()) for record in self.records)
        count = len(self.chain.theta)
        if known >= SHORT * count:
            return
        rng = np.random.default_rng(self.options.seed)
        slow = replace(self.chain, interval=self.thin[0].interval)
        bases = tuple(list_informed_starts(slow, self.thin, rng, 2, self.goal.starts[0]))
        strength = self._choose_strength(bases)
        self.goal = replace(self.goal, strength=strength, bases=bases)
        self.remarks.append(
            f"The records are short: {known} known outputs for {count} free numbers. A pull of {strength:g} towards "
            "a linear model, chosen by leaving out a third after the other, keeps them from following the noise; take "
            "longer records or a smaller structure."
        )

    def _choose_strength(self, bases: Sequence[Chain]) -> float:
        """Return the pull with the best prediction of left-out parts of the records; the stronger of equals."""
        errors = dict.fromkeys(STRENGTHS, 0.0)
        for fold in range(THIRDS):
            seen = [hide_block(r, cut_block(r, fold, THIRDS)) for r in self.thin]
            if not all(np.isfinite(r.outputs).any(axis=0).all() for r in seen):
                continue
            chains = list(bases)
            for strength in STRENGTHS:
                goal = self._goal_for(self.thin, replace(self.goal, strength=strength, bases=tuple(bases)), 3)
                ends = _refine_all(chains, seen, goal, lambda count, of: None)
                chains = [end.chain for end in ends] or chains
                errors[strength] += _measure_left_out(ends[0], self.thin, seen, goal) if ends else np.inf
        return min(STRENGTHS, key=lambda strength: errors[strength])

    def _describe(self, last: SearchEnd, fits: Sequence[float], coarse: Sequence[float]) -> ChainEstimate:
        found, chain, goal = last.found, last.chain, self.goal
        wanted = tuple(build_aims(self.records, self.options, goal.starts))
        complete = not goal.halt.is_set()
        self.remarks += describe_copies(self.records)
        if self.options.noise and complete:
            found, wanted = whiten_chain(chain, found, wanted, self.options)
            chain = chain.with_theta(found.theta[: len(chain.theta)])
        states = ResidualSquares(chain.engine, wanted).initial(found.theta)[: len(self.records)]
        chain = keep_starts(fence_chain(chain, self.records, states), self.records, goal.starts, states)
        if complete:
            self.remarks += describe_exchange(self.records, fits[0])
            if self.options.start == "rest":
                self.remarks += describe_motion([r for r in self.records if not shows_rest(r)])
        return ChainEstimate(
            chain, self.records, wanted, found, tuple(fits), tuple(coarse), self.options, complete, tuple(self.remarks)
        )

    def _search_starts(self) -> list[SearchEnd]:
        """Return the ends of first searches, best first, with what they tell of how the records begin."""
        ends = self._search_thin(self.goal, ())
        doubted = [self.options.start == AUTO and not shows_rest(record) for record in self.records]
        if not any(doubted) or not ends or self.goal.halt.is_set() or not self.chain.engine.plan.states:
            return ends
        try:
            return self._leave_rest(ends, doubted)
        except KeyboardInterrupt:
            self._halt()
            return ends

    def _leave_rest(self, ends: list[SearchEnd], doubted: Sequence[bool]) -> list[SearchEnd]:
        """Return the ends from rest, or better ones with initial states that are estimated."""
        starts = tuple("estimate" if doubt else "rest" for doubt in doubted)
        free = replace(self.goal, starts=starts)
        # separate searches: those from rest may have ended where other initial states do not help
        found = self._search_thin(free, [end.chain for end in ends[:PROBES]])
        rested = min(self._bare_cost(end, self.goal) for end in ends[:PROBES])
        if not found or min(self._bare_cost(end, free) for end in found[:PROBES]) > DOUBT * rested:
            return ends
        self.goal = free
        squares = self._goal_for(self.thin, free).bare_squares(found[0].chain, self.thin)
        self.goal = replace(free, starts=_find_rested(squares, found[0].found.theta))
        return found

    def _bare_cost(self, end: SearchEnd, goal: Goal) -> float:
        return self._goal_for(self.thin, goal).bare_squares(end.chain, self.thin).value(end.found.theta)

    def _goal_for(self, level: Sequence[Sampled], goal: Goal | None = None, shorter: int = 1) -> Goal:
        """Return the goal on thinner records: as long a start that does not count, perhaps fewer steps."""
        goal = goal or self.goal
        skip = round(goal.options.skip * self.records[0].interval / level[0].interval)
        steps = max(goal.options.iterations // shorter, 1)
        return replace(goal, options=replace(goal.options, skip=skip, iterations=steps))

    def _search_thin(self, goal: Goal, besides: Sequence[Chain]) -> list[SearchEnd]:
        """Return the ends of first searches over thin records, from given chains and from others."""
        options, records = goal.options, self.thin
        slow = replace(self.chain, interval=records[0].interval)
        given = [begin_from_chain(slow, one, records) for one in options.begin]
        rng = np.random.default_rng(options.seed)
        start = "estimate" if "estimate" in goal.starts else goal.starts[0]
        begin = [*given, *besides, *list_informed_starts(slow, records, rng, options.starts, start)]
        return _refine_all(begin, records, self._goal_for(records, goal, 2), self._share("start", 0.0, 0.5))

    def _share(self, word: str, low: float, high: float) -> Callable[[int, int], None]:
        """Return a callback for the number of ended searches and their total; a count of 0 is an interruption."""

        def told(count: int, of: int) -> None:
            if count:
                self.tell(f"{word} {count} of {of}", low + (high - low) * count / of)
            else:
                self.tell(INTERRUPTED, high)

        return told

    def _halt(self) -> None:
        accept_interrupt()
        self.goal.halt.set()
        self.tell(INTERRUPTED, 1.0)

    def _finish(self, refined: Sequence[SearchEnd], level: Sequence[Sampled]) -> SearchEnd:
        """Return the end of the best search at the full rate.

        Raises:
            SolveError: no model that was found on thinner records can be simulated there.
        """
        records, goal = self.records, self.goal
        if all(a is b for a, b in zip(level, records, strict=True)):
            return refined[0]
        full = [replace(end.chain, interval=records[0].interval) for end in refined]
        if goal.halt.is_set():
            return _stop_at(full[0], records, goal)
        try:
            best = min(full, key=lambda chain: _compute_cost(chain, records, goal))
            (last,) = _refine_all([best], records, self._goal_for(records, None, 4), self._share("full", 0.9, 1.0)) or (
                None,
            )
        except KeyboardInterrupt:
            self._halt()
            return _stop_at(full[0], records, goal)
        if last is None:
            raise SolveError(
                f"`{best.text()}` fits thinner records, but cannot be simulated at the full rate; "
                "thin the records or lower the order."
            )
        return last


def cut_block(record: Sampled, fold: int, folds: int) -> slice:
    """Return the samples of one of some blocks of equal length."""
    ends = np.linspace(0, len(record), folds + 1).astype(int)
    return slice(int(ends[fold]), int(ends[fold + 1]))


def hide_block(record: Sampled, block: slice) -> Sampled:
    """Return the record with the outputs of a block missing."""
    outputs = record.outputs.copy()
    outputs[block] = np.nan
    return record.with_outputs(outputs)


def _measure_left_out(end: SearchEnd, whole: Sequence[Sampled], seen: Sequence[Sampled], goal: Goal) -> float:
    """Return the squared error, over the variances, of what a search did not see."""
    states = goal.bare_squares(end.chain, seen).initial(end.found.theta)
    total = 0.0
    for record, part, state in zip(whole, seen, states, strict=True):
        away = (record.outputs - end.chain.simulate(record.inputs, state)) / np.nanstd(record.outputs, axis=0)
        total += float(np.nansum(np.where(np.isnan(part.outputs), away, 0.0) ** 2))
    return total if np.isfinite(total) else np.inf


def _find_rested(squares: ResidualSquares, theta: Numbers) -> tuple[str, ...]:
    """Return the start of every record: at rest if the estimated state makes little difference."""
    found: list[str] = []
    place = squares.columns
    for aim in squares.aims:
        kind = aim.start
        if kind == "estimate":
            own = [replace(aim, start=start) for start in ("estimate", "rest")]
            both = [ResidualSquares(squares.engine, [one]) for one in own]
            state = theta[place : place + squares.states]
            place += squares.states
            free = both[0].value(np.concatenate([theta[: squares.columns], state]))
            kind = "rest" if both[1].value(theta[: squares.columns]) * DOUBT < free else "estimate"
        found.append(kind)
    return tuple(found)


def _refine_all(
    chains: Sequence[Chain], records: Sequence[Sampled], goal: Goal, told: Callable[[int, int], None]
) -> list[SearchEnd]:
    """Return the ends of searches from chains over records, best first; Ctrl-C ends all of them where they are."""
    with ThreadPoolExecutor(goal.options.threads) as pool:
        running = [pool.submit(_refine_one, chain, records, goal) for chain in chains]
        try:
            for count, one in enumerate(running, start=1):
                one.result()
                told(count, len(chains))
        except BaseException as error:
            goal.halt.set()
            pool.shutdown(wait=True, cancel_futures=True)
            if not isinstance(error, KeyboardInterrupt):
                raise
            accept_interrupt()
        ends = [one.result() for one in running if not one.cancelled()]
    found = sorted((end for end in ends if end and np.isfinite(end.cost)), key=lambda end: end.cost)
    if goal.halt.is_set():
        if not found:
            raise KeyboardInterrupt
        told(0, len(chains))
    return found


def _refine_one(chain: Chain, records: Sequence[Sampled], goal: Goal) -> SearchEnd | None:
    """Return the nearest minimum over records of any sample time; where it was halted, None without a step."""
    chain = replace(chain, interval=records[0].interval)
    squares = goal.squares(chain, records)
    begun = squares.extend_parameters(chain.theta)
    best: list[Found] = []

    def watch(count: int, value: float, theta: Numbers) -> None:
        best[:] = [Found(theta, value, count, False)]

    try:
        found = minimise_cost(squares, begun, goal.options.iterations, watch=watch)
    except HaltedSearchError:
        if not best:
            return None
        found = best[0]
    known = sum(int(np.isfinite(r.outputs[goal.options.skip :]).sum()) for r in records)
    return SearchEnd(found.value / known, found, chain.with_theta(found.theta[: len(chain.theta)]))


def _stop_at(chain: Chain, records: Sequence[Sampled], goal: Goal) -> SearchEnd:
    """Return a chain as it is, with initial states that the first samples of its records tell."""
    squares = replace(goal, halt=Event()).squares(chain, records)
    theta = squares.extend_parameters(chain.theta)
    place = squares.columns
    for record, start in zip(records, goal.starts, strict=True):
        if start == "estimate":
            begin = find_start(chain, record, AUTO, goal.options.skip)
            if begin.state is not None:
                rest = chain.engine.rest(chain.theta, record.inputs[0]).state
                theta[place : place + squares.states] = begin.state - rest
            place += squares.states
    return SearchEnd(np.nan, Found(theta, np.nan, 0, False), chain)


def _compute_cost(chain: Chain, records: Sequence[Sampled], goal: Goal) -> float:
    """Return the cost of a search, with the best initial states if they are estimated."""
    squares = goal.squares(chain, records)
    if "estimate" not in goal.starts:
        return squares.value(chain.theta)
    return settle_states(squares, chain.theta, 10).value


def _compute_fit(end: SearchEnd, records: Sequence[Sampled], goal: Goal) -> float:
    """Return the mean fit [%] over records and outputs."""
    squares = ResidualSquares(end.chain.engine, build_aims(records, goal.options, goal.starts))
    same = len(end.found.theta) == squares.size
    states = squares.initial(end.found.theta if same else squares.extend_parameters(end.chain.theta))
    runs = [end.chain.simulate(r.inputs, state) for r, state in zip(records, states, strict=False)]
    fits = [fit_percent(r.outputs, run, goal.options.skip) for r, run in zip(records, runs, strict=True)]
    return float(np.mean(fits))
