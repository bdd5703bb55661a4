"""Tests of records before a structure is chosen: steady start, delay, order, linearity.

For the delay, inputs are shifted and a linear model is fitted for each shift. Delays with a squared error of at most
V₀ exp(3.84/n), with n independent residuals, are within its interval of 95 %. Linearity is tested on the residuals of
the best linear approximation: correlation with the square of the input (a bend), errors that differ between rising and
falling inputs (a loop); and by the coherence |S_yu|²/(S_u S_y), the largest fraction of the output that a linear
system could explain.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any

import numpy as np

from martensite.base.errors import MartensiteError
from martensite.identify.blocks.base import Numbers
from martensite.identify.blocks.state_space import StateSpace
from martensite.identify.blocks.transfer_function import TransferFunction
from martensite.identify.chains.best_linear import polish_linear
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.decimation import coarsen_records
from martensite.identify.chains.record_starts import shows_rest
from martensite.identify.chains.validation import Validation
from martensite.search.quantity_text import format_number
from martensite.search.whiteness import count_effective_samples
from martensite.signals.sampling.sampled import Sampled

SHIFTS = (-1, 0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48)
"""First candidates of the delay in samples, less one."""
WORSE = 1.5
"""Squared error over the least above which longer delays are not tried."""
CHI2 = 3.84
"""Quantile of 95 % of χ² with one degree of freedom."""
SEARCH_STEPS = 12
UNKNOWN = 0.9
"""Remaining fraction of the variance of a linear model above which the delay is unknown."""


@dataclass(frozen=True)
class DelayTest:
    """Delay in samples with its interval of 95 %."""

    value: int
    low: int
    high: int
    interval: float
    """Sample time [s]."""
    unexplained_variance: float
    """Fraction of the variance of the outputs that a linear model of this delay leaves."""

    @property
    def sentence(self) -> str:
        """Return the delay and its interval."""
        if self.unexplained_variance > UNKNOWN:
            return (
                "Delay: cannot be told, as linear models leave "
                f"{100.0 * self.unexplained_variance:.0f} % of the variance of the output; one sample is taken."
            )
        ends = f"{self.low} to {self.high}" if self.low < self.high else "no other"
        return (
            f"Delay: {self.value} samples ({format_number(self.value * self.interval, 3)} s); within 95 %: {ends}. "
            "A slow pole that the model lacks counts as delay."
        )


def find_delay(records: Sequence[Sampled], order: int = 2) -> DelayTest:
    """Return the delay with which a linear model reproduces records best."""
    thin = coarsen_records(records, 2000)
    if abs(thin[0].interval / records[0].interval - 1.0) > 1e-6:
        thin = [record.rows(0, 4000) for record in records]  # delays are counted in samples of the records
    profile = _profile_delays(thin, order)
    best = min(profile, key=lambda k: profile[k][0])
    least, count = profile[best]
    near = [k for k, (value, _) in profile.items() if count * np.log(value / least) <= CHI2] if least > 0.0 else [best]
    if best > min(near, default=best):  # the shortest good delay: a longer one may replace poles
        best = max(min(near), min(best, 0))
    left = least / sum(int(np.isfinite(r.outputs).all(axis=1).sum()) * r.outputs.shape[1] for r in thin)
    value = 0 if left > UNKNOWN else best
    low, high = min([value, *near]), max([value, *near])
    return DelayTest(value + 1, low + 1, high + 1, records[0].interval, left)


def _profile_delays(records: Sequence[Sampled], order: int) -> dict[int, tuple[float, float]]:
    """Return error and number of residuals by shift, coarse first, then around the minimum."""
    profile: dict[int, tuple[float, float]] = {}
    for shift in SHIFTS:
        if shift >= min(map(len, records)) // 4:
            break
        profile[shift] = _measure_shift(records, shift, order)
        best = min(profile, key=lambda k: profile[k][0])
        if profile[shift][0] > WORSE * profile[best][0] and shift > best + 1:
            break
    best = min(profile, key=lambda k: profile[k][0])
    for shift in range(max(best - 3, -1), min(best + 4, max(profile))):
        if shift not in profile:
            profile[shift] = _measure_shift(records, shift, order)
    return profile


def _measure_shift(records: Sequence[Sampled], shift: int, order: int) -> tuple[float, float]:
    """Return the squared error of a linear model with delayed inputs, and the number of independent residuals."""
    moved = [replace(r, inputs=r.inputs[np.clip(np.arange(len(r)) - shift, 0, len(r) - 1)]) for r in records]
    ins, outs = records[0].inputs.shape[1], records[0].outputs.shape[1]
    block = StateSpace(order=order, ins=ins, outs=outs, nk=1, offset="yes")
    if (ins, outs) == (1, 1):
        block = TransferFunction(nb=order, nf=order, nk=1)
    try:
        model = polish_linear(block, moved, iterations=SEARCH_STEPS)
    except MartensiteError:
        return np.inf, 1.0
    scale = np.nanstd(np.concatenate([r.outputs for r in records]), axis=0)
    errors = np.concatenate([(r.outputs - model.simulate(r.inputs)) / scale for r in moved])
    finite = errors[np.all(np.isfinite(errors), axis=1)]
    if not len(finite):
        return np.inf, 1.0
    return float(np.sum(finite**2)), count_effective_samples(finite[:, 0])


def describe_rest(records: Sequence[Sampled]) -> list[str]:
    """Return the start of every record, one sentence each."""
    return [
        f"`{record.name}` begins at rest: inputs are held at an end of their range and outputs stay."
        if shows_rest(record)
        else f"`{record.name}` does not show that it begins at rest: its initial state is found with the model."
        for record in records
    ]


def describe_coherence(record: Sampled) -> Iterator[str]:
    """Yield the fraction of the output that a linear system could explain, in a sentence; empty for short records."""
    share = measure_coherence(record)
    if np.isfinite(share):
        yield (
            f"`{record.name}`: coherence of `{record.input_names[0]}` and `{record.output_names[0]}` {share:.2f}, the "
            "share of the power of the output that a linear system could give."
        )


def measure_coherence(record: Sampled) -> float:
    """Return the fraction of the output power that a linear system could explain; NaN for a short record."""
    u = record.inputs[:, 0]
    y = record.outputs[:, 0]
    finite = np.isfinite(y)
    size = int(finite.sum()) // 8
    if size < 32 or not finite.any():
        return np.nan
    y = np.interp(np.arange(len(y)), np.flatnonzero(finite), y[finite])
    signal: Any = import_module("scipy.signal")
    _, shares = signal.coherence(u, y, nperseg=size, detrend="linear")
    _, power = signal.welch(y, nperseg=size, detrend="linear")
    return float(np.nansum(shares * power) / np.sum(power))


def describe_linearity(linear: Chain, checks: Sequence[Validation]) -> list[str]:
    """Return the evidence against a linear system, one sentence each."""
    evidence: list[str] = []
    for one in checks:
        bends = [test for test in one.correlations if "²" in test.signal and not test.explained]
        for test in bends:
            evidence.append(
                f"`{one.record.name}`: what `{linear.text()}` leaves follows {test.signal} "
                f"({format_number(test.following[1], 2)}, by chance {format_number(test.limit, 2)}): not linear."
            )
        if not bends and one.correlations:
            evidence.append(
                f"`{one.record.name}`: what `{linear.text()}` leaves does not follow the square of an input."
            )
        evidence += [text for text in one.failures if "uneven" in text]
    return evidence


def find_memory(record: Sampled, errors: Numbers) -> float:
    """Return the memory of residuals [s]: the duration over the number of independent residuals."""
    finite = errors[np.isfinite(errors)]
    return record.duration / count_effective_samples(finite) if len(finite) > 1 else np.nan
