"""Start of a record: at rest, as at the fit, or in a state estimated from its first samples.

The state at the first sample belongs to the record and not to the model. The state of a fitted record is found with the
model and kept with it (`Chain.starts`). The state of another record is estimated from its first samples, unless rest
explains these nearly as well. A run from a wrong state would distort the score of the model.

Source: the option `InitialCondition` of `compare` in the System Identification Toolbox, which estimates the state
on the whole record; here a short window keeps the score one of a free run.
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
"""Fraction of a record from which its state is estimated."""
LEAST_SAMPLES = 50
"""Samples for that at least."""
WORTH = 0.8
"""Squared error with another state than rest, over that from rest, from which on rest is given up."""
SEARCH_STEPS = 20
"""Number of steps of the search for a state."""
HELD = 20
"""Samples for which inputs must be held at first to tell rest from the record alone."""
FLAT = 0.05
"""Share of the range of an output by which it may drift, at the pace of the hold, over a quarter of the record."""
EDGE = 0.05
"""Share of the range of an input within which a hold is at an end of it."""


class RunStart(NamedTuple):
    """The state of a chain at the first sample of a record, and where it is from."""

    state: Numbers | None
    """None for rest."""
    said: str
    """In words."""


REST = RunStart(None, "at rest")


def find_start(chain: Chain, record: Sampled, start: str = AUTO, skip: int = 0) -> RunStart:
    """Return the state in which a chain begins a record.

    Args:
        chain: the model.
        record: of its sample time.
        start: `rest`, `zero`, or `estimate`, the state that fits the whole record best; by default that of the
            fit if the record was fitted, else the one inferred from the first tenth, if rest is much worse.
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
    known = chain.starts.get(record.hash) if chain.starts else None
    if known is not None:
        return REST if known.kind == "rest" else RunStart(chain.restore_state(known), "as at the fit")
    return _infer_start(chain, record, skip)


def _infer_start(chain: Chain, record: Sampled, skip: int) -> RunStart:
    """Rest, or the state that the first samples tell."""
    count = skip + max(round(START_FRACTION * len(record)), LEAST_SAMPLES, 4 * chain.engine.plan.states)
    window = record.rows(0, count)
    known = np.isfinite(window.outputs[skip:]).sum()
    if known <= chain.engine.plan.states:
        return REST
    state, cost, rested = _settle(chain, window, skip)
    spare = known / (known - chain.engine.plan.states)
    if not cost * spare < WORTH * rested:
        return REST
    with np.errstate(all="ignore"):
        if not np.all(np.isfinite(chain.engine.simulate(chain.theta, record.inputs, state.copy()))):
            return REST
    return RunStart(state, f"inferred from its first {format_number(window.duration, 3)} s")


def _settle(chain: Chain, record: Sampled, skip: int) -> tuple[Numbers, float, float]:
    """Return the state that fits a record best, its squared error, and that from rest."""
    squares = ResidualSquares(chain.engine, [RecordResidual(record, skip, start="estimate")])
    rested = squares.value(squares.extend_parameters(chain.theta))
    found = settle_states(squares, chain.theta, SEARCH_STEPS)
    return squares.initial(found.theta)[0], found.value, rested


def keep_starts(chain: Chain, records: Sequence[Sampled], starts: Sequence[str], states: Sequence[Numbers]) -> Chain:
    """Return the chain with the states in which its records begin, and the ranges that their signals had."""
    kept = {
        record.hash: RecordStart(record.name, kind, tuple(map(float, state)) if kind == "estimate" else ())
        for record, kind, state in zip(records, starts, states, strict=True)
    }
    return chain.with_records(kept, _find_ranges(records))


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
    """Return whether a record alone shows that it begins at rest.

    Its inputs are held at an end of their ranges at first, where nothing has come from further away, and its
    outputs stay: at their pace then they would not drift far.
    """
    moved = np.any(record.inputs != record.inputs[0], axis=1)
    count = int(np.argmax(moved)) if moved.any() else 0
    low, high = record.inputs.min(axis=0), record.inputs.max(axis=0)
    at_end = np.minimum(record.inputs[0] - low, high - record.inputs[0]) <= EDGE * (high - low)
    if count < HELD or not at_end.all():
        return False
    for column in record.outputs.T:
        y = column[:count]
        known = np.isfinite(y)
        if known.sum() < HELD:
            return False
        (slope, _), covariance = np.polyfit(np.flatnonzero(known), y[known], 1, cov=True)
        drift = (abs(slope) + 2.0 * np.sqrt(covariance[0, 0])) * 0.25 * len(record)
        if drift > FLAT * np.ptp(column[np.isfinite(column)]):
            return False
    return True
