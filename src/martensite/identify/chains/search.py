"""The search for a structure: every candidate estimated from many starts, scored in free run.

Scored on a record of another cadence than the estimation record, at the full rate: on the same
cadence lag and hysteresis cannot be told apart. Without such a record the score is that of
blocked cross-validation: each third of every record is left out of an estimation of its own and
scored. Of candidates within half a point of the best the one with the fewest free numbers is
chosen. The record that chose is used up by it: a final figure needs another one.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from martensite.base.errors import InputError, SolveError
from martensite.base.interrupts import accept_interrupt
from martensite.identify.chains.chain import build_untrained
from martensite.identify.chains.chain_text import expand_pattern, parse_chain
from martensite.identify.chains.doubts import describe_stillness
from martensite.identify.chains.estimate import ChainEstimate, Options, cut_block, estimate_chain, hide_block
from martensite.identify.chains.goals import AUTO, check_informative, check_records
from martensite.identify.chains.scores import fit_percent, free_run, mean_fit, score_chain
from martensite.signals.sampling.sampled import Sampled

MARGIN = 0.5
"""Points of fit within which the smaller structure is preferred."""
FOLDS = 3
"""Blocks of every record in cross-validation."""


@dataclass(frozen=True, eq=False)
class StructureCandidate:
    """One structure, and what became of it."""

    structure: str
    numbers: int
    """Free numbers."""
    found: ChainEstimate | None
    """None if no search gave a model; `fault` says why."""
    estimation: float
    """Mean fit [%] over the estimation records, free run."""
    validation: float
    """Mean fit [%] that it is chosen by, free run."""
    seconds: float
    fault: str = ""
    complete: bool = True
    """False if it was interrupted, in its searches or while it was judged."""

    @property
    def agreeing(self) -> int:
        """How many refined searches ended within 0.1 point of the best."""
        return 0 if self.found is None else self.found.agreeing

    @property
    def searches(self) -> int:
        """How many searches were refined."""
        return 0 if self.found is None else len(self.found.fits)


@dataclass(frozen=True, eq=False)
class Searched:
    """All candidates, the best first, and the one that was chosen."""

    candidates: tuple[StructureCandidate, ...]
    chosen: StructureCandidate
    by: str
    """What the candidates were chosen by, as words."""
    complete: bool = True
    """False if it was interrupted."""
    remarks: tuple[str, ...] = ()
    """What is doubtful about the choice, a sentence each."""

    @property
    def found(self) -> ChainEstimate:
        """The estimate of the chosen structure."""
        if self.chosen.found is None:
            raise SolveError("No structure of the search could be estimated.")
        return self.chosen.found


def search_structures(
    structures: str | Sequence[str],
    records: Sampled | Sequence[Sampled],
    validation: Sampled | Sequence[Sampled] = (),
    options: Options | None = None,
    watch: Callable[[str, float], None] | None = None,
) -> Searched:
    """The structure that predicts best, of all that patterns stand for.

    Args:
        structures: a pattern such as `poly{1..3} | oe({2..3},3,1) | pwl{5,10}`, or several.
        records: what every candidate is estimated from.
        validation: what it is chosen by, best of another cadence; without, by blocked
            cross-validation.
        options: how each is estimated.
        watch: called with a sentence and the share that is done.

    Raises:
        InputError: a structure or a record does not fit; nothing was estimated then.
        SolveError: no structure could be estimated.
    """
    options = options or Options()
    records = (records,) if isinstance(records, Sampled) else tuple(records)
    validation = (validation,) if isinstance(validation, Sampled) else tuple(validation)
    patterns = [structures] if isinstance(structures, str) else list(structures)
    texts = list(dict.fromkeys(text for pattern in patterns for text in expand_pattern(pattern)))
    if not texts:
        raise InputError("A search needs at least one structure.")
    check_records((*records, *validation))
    check_informative(records, options.skip, options.start)
    for text in texts:
        parse_chain(text)
    done: list[StructureCandidate] = []
    complete = True
    try:
        for k, text in enumerate(texts):
            tell = _name_candidate(watch, text, k, len(texts))
            done.append(_try_candidate(text, records, validation, options, tell))
            if not done[-1].complete:
                complete = False
                break
    except KeyboardInterrupt:
        complete = False
        if not done:
            raise
        accept_interrupt()
    found = _decide_next(done, validation, complete)
    return found if validation else replace(found, remarks=tuple(describe_stillness(records, FOLDS)))


def _decide_next(done: Sequence[StructureCandidate], validation: Sequence[Sampled], complete: bool) -> Searched:
    ranked = sorted(done, key=lambda c: -c.validation if math.isfinite(c.validation) else math.inf)
    good = [c for c in ranked if c.found is not None and math.isfinite(c.validation)]
    good = good or [c for c in ranked if c.found is not None]  # the first was interrupted before it was judged
    if not good:
        raise SolveError(f"No structure could be estimated. {ranked[0].fault}".strip())
    near = [c for c in good if not c.validation < good[0].validation - MARGIN]
    chosen = min(near, key=lambda c: (c.numbers, -c.validation))
    names = ", ".join(f"`{record.name}`" for record in validation)
    by = f"fit on {names}" if names else f"cross-validation over {FOLDS} blocks"
    return Searched(tuple(ranked), chosen, by, complete)


def _name_candidate(
    watch: Callable[[str, float], None] | None, text: str, k: int, count: int
) -> Callable[[str, float], None] | None:
    """What tells of one candidate among all."""
    if watch is None:
        return None
    return lambda words, share: watch(f"{k + 1} of {count}, {text}: {words}", (k + share) / count)


def _try_candidate(
    text: str,
    records: Sequence[Sampled],
    validation: Sequence[Sampled],
    options: Options,
    watch: Callable[[str, float], None] | None,
) -> StructureCandidate:
    begun = time.perf_counter()
    numbers = len(build_untrained(parse_chain(text), records[0]).theta)
    try:
        found = estimate_chain(text, records, options, watch)
        own = mean_fit(score_chain(found.chain, records, "estimation", options.start, options.skip))
        complete, score = found.complete, math.nan
        if validation:
            scores = score_chain(found.chain, validation, "validation", options.start, options.skip)
            score = mean_fit(scores)
        elif complete:
            try:
                score = cross_validated(text, records, _fix_starts(options, found))
            except KeyboardInterrupt:
                accept_interrupt()
                complete = False
    except (SolveError, InputError) as error:
        seconds = time.perf_counter() - begun
        return StructureCandidate(text, numbers, None, math.nan, math.nan, seconds, str(error))
    return StructureCandidate(text, numbers, found, own, score, time.perf_counter() - begun, complete=complete)


def _fix_starts(options: Options, found: ChainEstimate) -> Options:
    """The options, with what an estimation has found out of how the records begin, if all do alike."""
    kinds = {one.kind for one in found.chain.starts.values()}
    if options.start != AUTO or len(kinds) != 1:
        return options
    kind = kinds.pop()
    return replace(options, start=kind, anchor=options.anchor if kind == "rest" else 0.0)


def cross_validated(structure: str, records: Sequence[Sampled], options: Options, folds: int = FOLDS) -> float:
    """Fit [%] on what was left out, block after block, each of a chain estimated without it.

    Inputs are known throughout, so that every chain runs freely over whole records; only the
    outputs of its block are not seen by it.
    """
    left_out: list[list[np.ndarray]] = [[] for _ in records]
    for fold in range(folds):
        blocks = [cut_block(record, fold, folds) for record in records]
        seen = [hide_block(r, block) for r, block in zip(records, blocks, strict=True)]
        made = estimate_chain(structure, seen, options)
        if not made.complete:
            raise KeyboardInterrupt
        chain, start = made.chain, AUTO if options.start == "estimate" else options.start
        for parts, record, block in zip(left_out, seen, blocks, strict=True):
            parts.append(free_run(chain, record, start, options.skip)[block])
    fits = [
        fit_percent(record.outputs, np.concatenate(parts), options.skip)
        for record, parts in zip(records, left_out, strict=True)
    ]
    return float(np.mean(fits))
