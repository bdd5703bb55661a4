"""Searches of an estimation: refinement of several chains over records, held-out blocks, costs and fits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from threading import Event
from typing import NamedTuple

import numpy as np

from martensite.base.interrupts import accept_interrupt
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.goals import AUTO, Goal, build_aims
from martensite.identify.chains.record_starts import find_start
from martensite.identify.chains.residuals import HaltedSearchError, ResidualSquares, settle_states
from martensite.identify.chains.scores import fit_percent
from martensite.search.levenberg_marquardt import CostMinimum, Numbers, minimise_cost
from martensite.signals.sampling.sampled import Sampled

DOUBT = 0.9
"""Squared error with other initial states, over the steady state, below which a record does not start in it."""


class SearchEnd(NamedTuple):
    """End of a search."""

    cost: float
    """Sum of squares per known output, each over its scale."""
    solution: CostMinimum
    chain: Chain


def cut_block(record: Sampled, fold: int, folds: int) -> slice:
    """Return the samples of one of `folds` equal blocks."""
    ends = np.linspace(0, len(record), folds + 1).astype(int)
    return slice(int(ends[fold]), int(ends[fold + 1]))


def hide_block(record: Sampled, block: slice) -> Sampled:
    """Return the record without the outputs of a block."""
    outputs = record.outputs.copy()
    outputs[block] = np.nan
    return record.with_outputs(outputs)


def measure_left_out(
    end: SearchEnd, records: Sequence[Sampled], training_records: Sequence[Sampled], goal: Goal
) -> float:
    """Return the squared error on held-out outputs, over their variances."""
    states = goal.bare_squares(end.chain, training_records).initial(end.solution.theta)
    total = 0.0
    for record, part, state in zip(records, training_records, states, strict=True):
        away = (record.outputs - end.chain.simulate(record.inputs, state)) / np.nanstd(record.outputs, axis=0)
        total += float(np.nansum(np.where(np.isnan(part.outputs), away, 0.0) ** 2))
    return total if np.isfinite(total) else np.inf


def find_rested(squares: ResidualSquares, theta: Numbers) -> tuple[str, ...]:
    """Return the start of every record: `rest` if the estimated state makes little difference."""
    kinds: list[str] = []
    place = squares.columns
    for aim in squares.aims:
        kind = aim.start
        if kind == "estimate":
            variants = [replace(aim, start=start) for start in ("estimate", "rest")]
            pair = [ResidualSquares(squares.engine, [one]) for one in variants]
            state = theta[place : place + squares.states]
            place += squares.states
            free = pair[0].value(np.concatenate([theta[: squares.columns], state]))
            kind = "rest" if pair[1].value(theta[: squares.columns]) * DOUBT < free else "estimate"
        kinds.append(kind)
    return tuple(kinds)


def refine_all(
    chains: Sequence[Chain], records: Sequence[Sampled], goal: Goal, report: Callable[[int, int], None]
) -> list[SearchEnd]:
    """Return the ends of searches from chains, best first; Ctrl-C ends all of them where they are."""
    with ThreadPoolExecutor(goal.options.threads) as pool:
        running = [pool.submit(_refine_one, chain, records, goal) for chain in chains]
        try:
            for count, one in enumerate(running, start=1):
                one.result()
                report(count, len(chains))
        except BaseException as error:
            goal.halt.set()
            pool.shutdown(wait=True, cancel_futures=True)
            if not isinstance(error, KeyboardInterrupt):
                raise
            accept_interrupt()
        ends = [one.result() for one in running if not one.cancelled()]
    finished = sorted((end for end in ends if end and np.isfinite(end.cost)), key=lambda end: end.cost)
    if goal.halt.is_set():
        if not finished:
            raise KeyboardInterrupt
        report(0, len(chains))
    return finished


def _refine_one(chain: Chain, records: Sequence[Sampled], goal: Goal) -> SearchEnd | None:
    """Return the nearest minimum, or where the search was halted; None without a step."""
    chain = replace(chain, interval=records[0].interval)
    squares = goal.squares(chain, records)
    start = squares.extend_parameters(chain.theta)
    best: list[CostMinimum] = []

    def watch(count: int, value: float, theta: Numbers) -> None:
        best[:] = [CostMinimum(theta, value, count, False)]

    try:
        end = minimise_cost(squares, start, goal.options.iterations, watch=watch)
    except HaltedSearchError:
        if not best:
            return None
        end = best[0]
    count = sum(int(np.isfinite(r.outputs[goal.options.skip :]).sum()) for r in records)
    return SearchEnd(end.value / count, end, chain.with_theta(end.theta[: len(chain.theta)]))


def stop_at(chain: Chain, records: Sequence[Sampled], goal: Goal) -> SearchEnd:
    """Return a chain as it is, with initial states from the first samples of its records."""
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
    return SearchEnd(np.nan, CostMinimum(theta, np.nan, 0, False), chain)


def compute_cost(chain: Chain, records: Sequence[Sampled], goal: Goal) -> float:
    """Return the cost of a chain, with the best initial states if they are estimated."""
    squares = goal.squares(chain, records)
    if "estimate" not in goal.starts:
        return squares.value(chain.theta)
    return settle_states(squares, chain.theta, 10).value


def compute_fit(end: SearchEnd, records: Sequence[Sampled], goal: Goal) -> float:
    """Return the mean fit over records and outputs [%]."""
    squares = ResidualSquares(end.chain.engine, build_aims(records, goal.options, goal.starts))
    same = len(end.solution.theta) == squares.size
    states = squares.initial(end.solution.theta if same else squares.extend_parameters(end.chain.theta))
    runs = [end.chain.simulate(r.inputs, state) for r, state in zip(records, states, strict=False)]
    fits = [fit_percent(r.outputs, run, goal.options.skip) for r, run in zip(records, runs, strict=True)]
    return float(np.mean(fits))
