"""Scores of a chain on records: always of free runs, in which no measured output is fed back.

A fit on the records of the estimation proves little: a slow linear block can imitate hysteresis at one cadence and fail
at any other. `role` is the use of a record.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.goals import AUTO
from martensite.identify.chains.record_starts import REST, RunStart, find_start
from martensite.signals.sampling.resampling import resample_record
from martensite.signals.sampling.sampled import Sampled

ROLES = ("estimation", "validation", "other")
"""Use of a record: to fit, to choose, or not used yet."""


@dataclass(frozen=True)
class OutputScore:
    """Score of one output of one record in free run."""

    model: str
    role: str
    record: str
    output: str
    unit: str
    fit: float
    """NRMSE fit [%]."""
    rms: float
    """Root mean square of the error, in the unit of the output."""
    worst: float
    """Largest error."""
    begins: str = REST.said
    """In which state the run begins, in words."""


def fit_percent(measured: Numbers, computed: Numbers, skip: int = 0) -> Numbers:
    """NRMSE fit 100 (1 - |y - ŷ|/|y - mean y|) [%] of every output, over the known samples."""
    y, error = measured[skip:], (measured - computed)[skip:]
    away = np.sqrt(np.nansum((y - np.nanmean(y, axis=0)) ** 2, axis=0))
    return 100.0 * (1.0 - np.sqrt(np.nansum(error**2, axis=0)) / away)


def compute_rms(measured: Numbers, computed: Numbers, skip: int = 0) -> Numbers:
    """Return the root mean square of the error of every output."""
    return np.sqrt(np.nanmean((measured - computed)[skip:] ** 2, axis=0))


def free_run(chain: Chain, record: Sampled, start: str = AUTO, skip: int = 0) -> Numbers:
    """Outputs of a free run over the inputs of a record, shape (samples, outputs); see `record_starts.find_start`.

    Raises:
        InputError: record and model do not fit.
    """
    return run_from(chain, record, find_start(chain, record, start, skip))


def run_from(chain: Chain, record: Sampled, begin: RunStart) -> Numbers:
    """Return the outputs of a run from a state."""
    rested = chain.engine.rest(chain.theta, record.inputs[0]).state if begin.state is None else begin.state
    return chain.simulate(record, rested)


def score_chain(
    chain: Chain, records: Iterable[Sampled], role: str, start: str = AUTO, skip: int = 0, model: str = "model"
) -> list[OutputScore]:
    """Return the scores of all outputs over records, at their full rate.

    A record of another sample time is brought to that of the model first. Where states are estimated,
    that of a record which was not fitted is inferred from its first samples, not from all that is scored.
    """
    start = AUTO if start == "estimate" else start
    found: list[OutputScore] = []
    for record in records:
        if abs(record.interval / chain.interval - 1.0) > 1e-6:
            record = resample_record(record, chain.interval)
        begin = find_start(chain, record, start, skip)
        computed = run_from(chain, record, begin)
        fits, errors = (f(record.outputs, computed, skip) for f in (fit_percent, compute_rms))
        worst = np.nanmax(np.abs(record.outputs - computed)[skip:], axis=0)
        found += [
            OutputScore(
                model,
                role,
                record.name,
                name,
                record.units.get(name, "1"),
                float(fits[k]),
                float(errors[k]),
                float(worst[k]),
                begin.said,
            )
            for k, name in enumerate(record.output_names)
        ]
    return found
