"""Start of a record: steady, as in the fit, or in a state estimated from its first samples.

The state at the first sample belongs to the record. For records of the fit it is estimated with the model and stored in
it (`Chain.starts`). For other records it is estimated from the first samples, unless a steady start explains these
nearly as well. A wrong state would distort the score of the model.

Source: the option `InitialCondition` of `compare` in the System Identification Toolbox, which estimates the state from
the whole record; a short window keeps the score that of a free run.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.chain import Chain, RecordStart
from martensite.identify.chains.goals import AUTO
from martensite.identify.chains.residuals import RecordResidual, ResidualSquares, settle_states
from martensite.search.quantity_text import format_number
from martensite.signals.sampling.sampled import Sampled

START_FRACTION = 0.1
"""Fraction of a record for the estimate of its state."""
LEAST_SAMPLES = 50
"""Least number of samples for it."""
WORTH = 0.8
"""Squared error with another state, over the steady start, below which the other state is used."""
SEARCH_STEPS = 20
HELD = 20
"""Samples of constant inputs that show a steady start."""
FLAT = 0.05
"""Largest drift of an output over a quarter of the record, as a fraction of its range."""
EDGE = 0.05
"""Distance of a constant input from the end of its range, as a fraction of the range."""


class RunStart(NamedTuple):
    """State of a chain at the first sample of a record."""

    state: Numbers | None
    """State; None for a steady start."""
    description: str


REST = RunStart(None, "at rest")


def find_start(chain: Chain, record: Sampled, start: str = AUTO, skip: int = 0) -> RunStart:
    """Return the state in which a chain begins a record.

    Args:
        chain: the model.
        record: record of its sample time.
        start: `rest`, `zero`, or `estimate` from the whole record; default: as in the fit, or inferred from the first
            tenth if a steady start is much worse.
        skip: samples at the start that do not count.

    Raises:
        InputError: record and model do not fit.
    """
    states = chain.engine.plan.states
    if start == "rest" or not states:
        return REST
    if start == "zero":
        return RunStart(np.zeros(states), "zero")
    if start == "estimate":
        return RunStart(_settle(chain, record, skip)[0], "estimated from all of it")
    stored = chain.starts.get(record.hash) if chain.starts else None
    if stored is not None:
        return REST if stored.kind == "rest" else RunStart(chain.restore_state(stored), "as at the fit")
    return _infer_start(chain, record, skip)


def _infer_start(chain: Chain, record: Sampled, skip: int) -> RunStart:
    """Return a steady start, or the state inferred from the first samples."""
    count = skip + max(round(START_FRACTION * len(record)), LEAST_SAMPLES, 4 * chain.engine.plan.states)
    window = record.rows(0, count)
    count_known = np.isfinite(window.outputs[skip:]).sum()
    if count_known <= chain.engine.plan.states:
        return REST
    state, cost, cost_at_rest = _settle(chain, window, skip)
    spare = count_known / (count_known - chain.engine.plan.states)
    if not cost * spare < WORTH * cost_at_rest:
        return REST
    with np.errstate(all="ignore"):
        if not np.all(np.isfinite(chain.engine.simulate(chain.theta, record.inputs, state.copy()))):
            return REST
    return RunStart(state, f"inferred from its first {format_number(window.duration, 3)} s")


def _settle(chain: Chain, record: Sampled, skip: int) -> tuple[Numbers, float, float]:
    """Return the state that fits a record best, its squared error, and the squared error of a steady start."""
    squares = ResidualSquares(chain.engine, [RecordResidual(record, skip, start="estimate")])
    cost_at_rest = squares.value(squares.extend_parameters(chain.theta))
    end = settle_states(squares, chain.theta, SEARCH_STEPS)
    return squares.initial(end.theta)[0], end.value, cost_at_rest


def keep_starts(chain: Chain, records: Sequence[Sampled], starts: Sequence[str], states: Sequence[Numbers]) -> Chain:
    """Return the chain with the starts of its records and the ranges of their signals."""
    starts_by_hash = {
        record.hash: RecordStart(record.name, kind, tuple(map(float, state)) if kind == "estimate" else ())
        for record, kind, state in zip(records, starts, states, strict=True)
    }
    return chain.with_records(starts_by_hash, _find_ranges(records))


def _find_ranges(records: Sequence[Sampled]) -> dict[str, tuple[float, float]]:
    columns: dict[str, list[Numbers]] = {}
    for record in records:
        for name, column in zip(
            (*record.input_names, *record.output_names), (*record.inputs.T, *record.outputs.T), strict=True
        ):
            columns.setdefault(name, []).append(column)
    joined = {name: np.concatenate(parts) for name, parts in columns.items()}
    return {name: (float(np.nanmin(values)), float(np.nanmax(values))) for name, values in joined.items()}


def shows_rest(record: Sampled) -> bool:
    """Return whether a record alone shows a steady start.

    Its inputs are constant at first, at an end of their ranges, and its outputs hardly drift.
    """
    moved = np.any(record.inputs != record.inputs[0], axis=1)
    count = int(np.argmax(moved)) if moved.any() else 0
    low, high = record.inputs.min(axis=0), record.inputs.max(axis=0)
    at_end = np.minimum(record.inputs[0] - low, high - record.inputs[0]) <= EDGE * (high - low)
    if count < HELD or not at_end.all():
        return False
    for column in record.outputs.T:
        y = column[:count]
        finite = np.isfinite(y)
        if finite.sum() < HELD:
            return False
        (slope, _), covariance = np.polyfit(np.flatnonzero(finite), y[finite], 1, cov=True)
        drift = (abs(slope) + 2.0 * np.sqrt(covariance[0, 0])) * 0.25 * len(record)
        if drift > FLAT * np.ptp(column[np.isfinite(column)]):
            return False
    return True
