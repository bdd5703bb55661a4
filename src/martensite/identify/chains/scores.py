"""Scores of a chain on records, always of free runs without measured outputs.

A fit on the records of the estimation proves little: a slow linear block can imitate hysteresis at one pulse rate and
fail at any other. `role` is the use of a record.
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
    worst: float
    begins: str = REST.description


def fit_percent(measured: Numbers, computed: Numbers, skip: int = 0) -> Numbers:
    """Return the NRMSE fit 100 (1 - |y - ŷ|/|y - mean y|) [%] of every output, over the known samples."""
    y, error = measured[skip:], (measured - computed)[skip:]
    away = np.sqrt(np.nansum((y - np.nanmean(y, axis=0)) ** 2, axis=0))
    return 100.0 * (1.0 - np.sqrt(np.nansum(error**2, axis=0)) / away)


def compute_rms(measured: Numbers, computed: Numbers, skip: int = 0) -> Numbers:
    """Return the root mean square error of every output."""
    return np.sqrt(np.nanmean((measured - computed)[skip:] ** 2, axis=0))


def free_run(chain: Chain, record: Sampled, start: str = AUTO, skip: int = 0) -> Numbers:
    """Return the outputs of a free run, shape (samples, outputs); see `record_starts.find_start`.

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
    """Return the scores of all outputs over records, at their full sample rate.

    A record of another sample time is resampled first. For `estimate`, the state of a new record is inferred from its
    first samples, not from all scored samples.
    """
    start = AUTO if start == "estimate" else start
    scores: list[OutputScore] = []
    for record in records:
        if abs(record.interval / chain.interval - 1.0) > 1e-6:
            record = resample_record(record, chain.interval)
        begin = find_start(chain, record, start, skip)
        computed = run_from(chain, record, begin)
        fits, errors = (f(record.outputs, computed, skip) for f in (fit_percent, compute_rms))
        worst = np.nanmax(np.abs(record.outputs - computed)[skip:], axis=0)
        scores += [
            OutputScore(
                model,
                role,
                record.name,
                name,
                record.units.get(name, "1"),
                float(fits[k]),
                float(errors[k]),
                float(worst[k]),
                begin.description,
            )
            for k, name in enumerate(record.output_names)
        ]
    return scores
