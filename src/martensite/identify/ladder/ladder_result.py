"""Result of a climb: every tried structure, the model, and its predictive value."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from martensite.identify.chains.chain import Chain
from martensite.identify.chains.scores import OutputScore
from martensite.identify.chains.validation import WHOLE, Validation
from martensite.identify.ladder.blocked_records import BlockedRecord, BlockErrors, ErrorFall, compare_errors
from martensite.identify.ladder.record_tests import find_memory
from martensite.search.quantity_text import format_number

JUDGED = 0.95
"""Confidence level of the verdict."""


@dataclass(frozen=True, eq=False)
class LadderTrial:
    """One tried structure."""

    structure: str
    numbers: int
    chain: Chain | None
    """Model; None if no search succeeded, and for the mean."""
    chosen_by: BlockErrors
    """Errors on the blocks to choose by."""
    held: BlockErrors
    seconds: float
    """Processor time [s]."""
    fault: str = ""


@dataclass(frozen=True, eq=False)
class LadderRung:
    """Trials of a rung, best first."""

    name: str
    trials: tuple[LadderTrial, ...]
    gain: ErrorFall
    """Improvement of the best trial over the model before."""
    kept: bool


@dataclass(frozen=True, eq=False)
class Ladder:
    """A climb with its final model."""

    blocked: tuple[BlockedRecord, ...]
    baseline: LadderTrial
    rungs: tuple[LadderRung, ...]
    chosen: LadderTrial
    """Highest accepted rung, or the best linear model if none is better than the mean."""
    model: Chain
    """Chosen structure, fitted to all data that are not held out."""
    held: BlockErrors
    checks: tuple[Validation, ...]
    tests: tuple[str, ...]
    apart: tuple[str, ...]
    """Records of another regime, one sentence each."""
    apart_scores: tuple[OutputScore, ...]
    """Scores of the model on these records."""
    doubts: tuple[str, ...]
    """Reasons why records are uninformative, or the result is unreliable."""
    remarks: tuple[str, ...] = ()
    stopped: str = ""
    """`time box` or `interrupted` if the climb ended early."""

    @property
    def gain(self) -> ErrorFall:
        """Return the improvement over the mean on held-out data."""
        return compare_errors(self.baseline.held, self.held, JUDGED)

    @property
    def predicts(self) -> bool:
        """Return whether the model predicts held-out blocks better than the mean, and than a constant fitted there."""
        return self.gain.certain and self.held.fit > 0.0

    @property
    def verdict(self) -> str:
        """Describe the predictive value of the model in a sentence."""
        text = f"`{self.model.text()}`"
        scores = f"fit {self.held.fit:.1f} % on held-out data (mean of the output: {self.baseline.held.fit:.1f} %)"
        sizes = [f"{format_number(s.rms, 2)} {s.unit}" for one in self.checks for s in one.scores if s.part == WHOLE]
        scores += f", rms error {', '.join(sizes)}" if sizes else ""
        if not self.predicts:
            return f"{text} does not predict better than the mean of the output: {scores}."
        return f"{text} predicts: {scores}."

    @property
    def advice(self) -> tuple[str, ...]:
        """Return advice for the next records, one sentence each."""
        return tuple(_advise(self))


def _advise(ladder: Ladder) -> Iterator[str]:
    """Yield advice for the next records."""
    records = [one.record for one in ladder.blocked if one.fitted]
    if ladder.doubts:
        yield "An input that moves throughout: steps and ramps of several heights, at least two rates, minor loops."
    if not ladder.predicts:
        yield (
            "An output that answers: check that both columns are of one experiment and not exchanged, drive harder, "
            "and record longer."
        )
    memory = max((_find_memory(one) for one in ladder.checks), default=np.nan)
    if np.isfinite(memory) and memory > 0.02 * min(record.duration for record in records):
        yield (
            f"Residuals remember {format_number(memory, 2)} s: a longer record, or one of another cadence given by "
            "--validate, would tell a slow effect from drift."
        )
    if any(not one.explained for one in ladder.checks):
        yield (
            "Residuals still follow the input: more levels and reversals of the input, or a structure of your own "
            "(--stage)."
        )
    if len(ladder.blocked) == 1:
        yield (
            "A log of another cadence (other rates, minor loops), given by --other: all blocks of one log share "
            "theirs, in which lag and hysteresis look alike."
        )


def _find_memory(check: Validation) -> float:
    return max(find_memory(check.record, errors) for errors in check.residuals.T)
