"""Estimation of a chain from records: many starts, the best of them refined with more samples.

First searches run on about 5000 samples per record, the best ones continue with 25 000, and the best of these ends at
the full sample rate. Shorter records skip a level.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from threading import Event

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
from martensite.identify.chains.record_starts import keep_starts, shows_rest
from martensite.identify.chains.residuals import HaltedSearchError, RecordResidual, ResidualSquares
from martensite.identify.chains.searches import (
    DOUBT,
    SearchEnd,
    compute_cost,
    compute_fit,
    cut_block,
    find_rested,
    hide_block,
    measure_left_out,
    refine_all,
    stop_at,
)
from martensite.identify.chains.starts import begin_from_chain, list_informed_starts
from martensite.identify.chains.uncertainty import ChainUncertainty, estimate_chain_uncertainty
from martensite.search.levenberg_marquardt import CostMinimum, minimise_cost
from martensite.signals.sampling.sampled import Sampled

INTERRUPTED = "interrupted"
"""Message to `watch` if Ctrl-C ended a search early; the best chain so far is kept."""
ALIKE = 0.1
"""Difference of fits of two equal results [points]."""
SHORT = 30
"""Known outputs per free number below which records are short."""
STRENGTHS = (1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-6)
"""Candidates for the pull on short records, relative to the effect on the outputs."""
THIRDS = 3
PROBES = 3
"""Number of best searches that continue with other initial states."""
Tell = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class ChainEstimate:
    """An estimated chain."""

    chain: Chain
    records: tuple[Sampled, ...]
    aims: tuple[RecordResidual, ...]
    solution: CostMinimum
    """End of the last search, at the full sample rate."""
    fits: tuple[float, ...]
    """Fit [%] at the ends of all refined searches, best first; for long records on decimated records."""
    options: Options = field(default_factory=Options)
    complete: bool = True
    """False for the best chain of an interrupted search."""
    remarks: tuple[str, ...] = ()
    """Doubts, one sentence each."""

    @property
    def agreeing(self) -> int:
        """Return the number of refined searches within 0.1 point of the best."""
        return sum(fit >= self.fits[0] - ALIKE for fit in self.fits)

    def squares(self) -> ResidualSquares:
        """Return the minimised sum of squares."""
        return ResidualSquares(self.chain.engine, self.aims)

    @cached_property
    def uncertainty(self) -> ChainUncertainty | None:
        """Return the uncertainty of the free numbers; None for an interrupted search, which ends at no minimum."""
        if not self.complete:
            return None
        states = self.solution.theta[len(self.chain.theta) :]
        return estimate_chain_uncertainty(self.chain, self.squares(), states=states)


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
        options: options of the search.
        watch: called with a sentence and the completed fraction.
        halt: if set, searches end as after Ctrl-C.

    Raises:
        InputError: records or structure do not fit.
        SolveError: no search gave a model that can be simulated.
        KeyboardInterrupt: the search was halted before there was a model.
    """
    options = options or Options()
    records = (records,) if isinstance(records, Sampled) else tuple(records)
    check_records(records)
    check_informative(records, options.skip, options.start)
    parsed = parse_chain(blocks) if isinstance(blocks, str) else tuple(blocks)
    _check_signals(parsed, records[0])
    chain = build_untrained(parsed, max(records, key=len))
    check_enough(chain, records, options.skip)
    parsed = _Estimation(chain, records, options, watch or (lambda text, share: None))
    parsed.goal = replace(parsed.goal, halt=halt or parsed.goal.halt)
    try:
        return parsed.run()
    except HaltedSearchError:  # between two searches
        raise KeyboardInterrupt from None


def _check_signals(blocks: Sequence[AbstractBlock], record: Sampled) -> None:
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


def refine_chain(chain: Chain, records: Sequence[Sampled], options: Options) -> CostMinimum:
    """Return the nearest minimum from the numbers of a chain, at the full sample rate."""
    squares = Goal.begin(options, records).squares(chain, records)
    return minimise_cost(squares, squares.extend_parameters(chain.theta), options.iterations)


class _Estimation:
    """Searches of one estimation; an interruption keeps the best chain."""

    def __init__(self, chain: Chain, records: tuple[Sampled, ...], options: Options, tell: Tell) -> None:
        self.chain, self.records, self.options, self.tell = chain, records, options, tell
        self.thin, self.middle = coarsen_records(records), coarsen_records(records, MIDDLE)
        self.goal = Goal.begin(options, records)
        self.remarks: list[str] = []

    def run(self) -> ChainEstimate:
        if self.options.ridge is None:
            self._guard_short()
        first = self._search_starts()
        refined, level = first, self.thin
        if not self.goal.halt.is_set():
            try:
                best = [end.chain for end in first[: max(self.options.refined, 1)]]
                goal = self._goal_for(self.middle)
                refined, level = refine_all(best, self.middle, goal, self._share("refined", 0.5, 0.9)), self.middle
            except KeyboardInterrupt:
                self._halt()
        if not refined:
            raise SolveError(
                f"No search for `{self.chain.text()}` gave a model that can be simulated; try more "
                "starts, fewer units or a lower order."
            )
        last = self._finish(refined, level)
        self.tell("full rate", 1.0)
        fits = [compute_fit(end, level, self._goal_for(level)) for end in refined]
        return self._describe(last, sorted(fits, reverse=True))

    def _guard_short(self) -> None:
        """Pull the parameters towards a linear model if the records are short for their number."""
        samples = sum(int(np.isfinite(record.outputs[self.options.skip :]).sum()) for record in self.records)
        count = len(self.chain.theta)
        if samples >= SHORT * count:
            return
        rng = np.random.default_rng(self.options.seed)
        slow = replace(self.chain, interval=self.thin[0].interval)
        bases = tuple(list_informed_starts(slow, self.thin, rng, 2, self.goal.starts[0]))
        strength = self._choose_strength(bases)
        self.goal = replace(self.goal, strength=strength, bases=bases)
        self.remarks.append(
            f"The records are short: {samples} known outputs for {count} free numbers. A pull of {strength:g} towards "
            "a linear model, chosen by leaving out a third after the other, keeps them from following the noise; take "
            "longer records or a smaller structure."
        )

    def _choose_strength(self, bases: Sequence[Chain]) -> float:
        """Return the pull with the best prediction of held-out parts of the records."""
        errors = dict.fromkeys(STRENGTHS, 0.0)
        for fold in range(THIRDS):
            training_records = [hide_block(r, cut_block(r, fold, THIRDS)) for r in self.thin]
            if not all(np.isfinite(r.outputs).any(axis=0).all() for r in training_records):
                continue
            chains = list(bases)
            for strength in STRENGTHS:
                goal = self._goal_for(self.thin, replace(self.goal, strength=strength, bases=tuple(bases)), 3)
                ends = refine_all(chains, training_records, goal, lambda count, of: None)
                chains = [end.chain for end in ends] or chains
                errors[strength] += measure_left_out(ends[0], self.thin, training_records, goal) if ends else np.inf
        return min(STRENGTHS, key=lambda strength: errors[strength])

    def _describe(self, last: SearchEnd, fits: Sequence[float]) -> ChainEstimate:
        found_end, chain, goal = last.solution, last.chain, self.goal
        wanted = tuple(build_aims(self.records, self.options, goal.starts))
        complete = not goal.halt.is_set()
        self.remarks += describe_copies(self.records)
        if self.options.noise and complete:
            found_end, wanted = whiten_chain(chain, found_end, wanted, self.options)
            chain = chain.with_theta(found_end.theta[: len(chain.theta)])
        states = ResidualSquares(chain.engine, wanted).initial(found_end.theta)[: len(self.records)]
        chain = keep_starts(fence_chain(chain, self.records, states), self.records, goal.starts, states)
        if complete:
            self.remarks += describe_exchange(self.records, fits[0])
            if self.options.start == "rest":
                self.remarks += describe_motion([r for r in self.records if not shows_rest(r)])
        remarks = tuple(self.remarks)
        return ChainEstimate(chain, self.records, wanted, found_end, tuple(fits), self.options, complete, remarks)

    def _search_starts(self) -> list[SearchEnd]:
        """Return the ends of first searches, best first, and test how the records start."""
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
        """Return the ends from the steady state, or better ones with estimated initial states."""
        starts = tuple("estimate" if doubt else "rest" for doubt in doubted)
        free = replace(self.goal, starts=starts)
        # searches from rest may have ended where other initial states do not help
        ends_free = self._search_thin(free, [end.chain for end in ends[:PROBES]])
        cost_at_rest = min(self._bare_cost(end, self.goal) for end in ends[:PROBES])
        if not ends_free or min(self._bare_cost(end, free) for end in ends_free[:PROBES]) > DOUBT * cost_at_rest:
            return ends
        self.goal = free
        squares = self._goal_for(self.thin, free).bare_squares(ends_free[0].chain, self.thin)
        self.goal = replace(free, starts=find_rested(squares, ends_free[0].solution.theta))
        return ends_free

    def _bare_cost(self, end: SearchEnd, goal: Goal) -> float:
        return self._goal_for(self.thin, goal).bare_squares(end.chain, self.thin).value(end.solution.theta)

    def _goal_for(self, level: Sequence[Sampled], goal: Goal | None = None, shorter: int = 1) -> Goal:
        """Return the goal on decimated records, with fewer steps if `shorter` is above 1."""
        goal = goal or self.goal
        skip = round(goal.options.skip * self.records[0].interval / level[0].interval)
        steps = max(goal.options.iterations // shorter, 1)
        return replace(goal, options=replace(goal.options, skip=skip, iterations=steps))

    def _search_thin(self, goal: Goal, besides: Sequence[Chain]) -> list[SearchEnd]:
        """Return the ends of first searches on decimated records."""
        options, records = goal.options, self.thin
        slow = replace(self.chain, interval=records[0].interval)
        given = [begin_from_chain(slow, one, records) for one in options.begin]
        rng = np.random.default_rng(options.seed)
        start = "estimate" if "estimate" in goal.starts else goal.starts[0]
        begin = [*given, *besides, *list_informed_starts(slow, records, rng, options.starts, start)]
        return refine_all(begin, records, self._goal_for(records, goal, 2), self._share("start", 0.0, 0.5))

    def _share(self, word: str, low: float, high: float) -> Callable[[int, int], None]:
        """Return a callback for the number of ended searches and their total; a count of 0 is an interruption."""

        def report(count: int, of: int) -> None:
            if count:
                self.tell(f"{word} {count} of {of}", low + (high - low) * count / of)
            else:
                self.tell(INTERRUPTED, high)

        return report

    def _halt(self) -> None:
        accept_interrupt()
        self.goal.halt.set()
        self.tell(INTERRUPTED, 1.0)

    def _finish(self, refined: Sequence[SearchEnd], level: Sequence[Sampled]) -> SearchEnd:
        """Return the end of the best search at the full sample rate."""
        records, goal = self.records, self.goal
        if all(a is b for a, b in zip(level, records, strict=True)):
            return refined[0]
        full = [replace(end.chain, interval=records[0].interval) for end in refined]
        if goal.halt.is_set():
            return stop_at(full[0], records, goal)
        try:
            best = min(full, key=lambda chain: compute_cost(chain, records, goal))
            (last,) = refine_all([best], records, self._goal_for(records, None, 4), self._share("full", 0.9, 1.0)) or (
                None,
            )
        except KeyboardInterrupt:
            self._halt()
            return stop_at(full[0], records, goal)
        if last is None:
            raise SolveError(
                f"`{best.text()}` fits thinner records, but cannot be simulated at the full rate; "
                "thin the records or lower the order."
            )
        return last
