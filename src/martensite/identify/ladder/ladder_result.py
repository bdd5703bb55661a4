"""Result of a climb: every tried structure, the model, and its predictive value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from martensite.identify.chains.chain import Chain
from martensite.identify.chains.scores import OutputScore
from martensite.identify.chains.validation import WHOLE, Validation
from martensite.identify.ladder.blocked_records import BlockedRecord, BlockErrors, ErrorFall, compare_errors
from martensite.identify.ladder.record_tests import find_memory
from martensite.search.quantity_text import format_number
from martensite.search.rivals import EXPLAINED, Prediction

MEAN = "mean of the output"
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
    held_out: BlockErrors
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
    is_accepted: bool


@dataclass(frozen=True, eq=False)
class Ladder:
    """A climb with its final model."""

    blocked_records: tuple[BlockedRecord, ...]
    baseline: LadderTrial
    rungs: tuple[LadderRung, ...]
    chosen_trial: LadderTrial
    """Highest accepted rung, or the best linear model if none is better than the mean."""
    model: Chain
    """Chosen structure, fitted to all data that are not held out."""
    held_out: BlockErrors
    checks: tuple[Validation, ...]
    tests: tuple[str, ...]
    apart: tuple[str, ...]
    """Records of another regime, one sentence each."""
    apart_scores: tuple[OutputScore, ...]
    """Scores of the model on these records."""
    doubts: tuple[str, ...]
    """Reasons why records are uninformative, or the result is unreliable."""
    remarks: tuple[str, ...] = ()
    stop_reason: str = ""
    """`time box` or `interrupted` if the climb ended early."""
    rivals: Mapping[str, float] = field(default_factory=dict[str, float])
    """Prediction without a model -> its fit [%] on the held-out blocks; without the mean."""

    @property
    def gain(self) -> ErrorFall:
        """Return the improvement over the mean on held-out data."""
        return compare_errors(self.baseline.held_out, self.held_out, JUDGED)

    @property
    def prediction(self) -> Prediction:
        """Return the held-out errors of the model and of all rivals, over the spread of the output."""
        fits = {MEAN: self.baseline.held_out.fit, **self.rivals}
        errors = {name: 1.0 - 0.01 * fit for name, fit in fits.items()}
        return Prediction(1.0 - 0.01 * self.held_out.fit, 1.0, errors)

    @property
    def predicts(self) -> bool:
        """Return whether the model predicts by the rule of all fits, and not by chance better than the mean."""
        return self.gain.certain and self.prediction.predicts

    @property
    def verdict(self) -> str:
        """Describe the predictive value of the model in a sentence."""
        text = f"`{self.model.text()}`"
        fits = {MEAN: self.baseline.held_out.fit, **self.rivals}
        listed = ", ".join(f"{name}: {fit:.1f} %" for name, fit in fits.items())
        scores = f"fit {self.held_out.fit:.1f} % on held-out data ({listed})"
        sizes = [f"{format_number(s.rms, 2)} {s.unit}" for one in self.checks for s in one.scores if s.part == WHOLE]
        scores += f", rms error {', '.join(sizes)}" if sizes else ""
        if self.predicts:
            return f"{text} predicts: {scores}."
        prediction = self.prediction
        rival = prediction.best_rival if self.gain.certain else MEAN
        if not self.gain.certain or not prediction.beats_rivals:
            return f"{text} does not predict better than the {rival}: {scores}."
        return f"{text} does not predict: it explains less than {100.0 * EXPLAINED:.0f} %: {scores}."

    @property
    def advice(self) -> tuple[str, ...]:
        """Return advice for the next records, one sentence each."""
        return tuple(_advise(self))


def _advise(ladder: Ladder) -> Iterator[str]:
    """Yield advice for the next records."""
    records = [one.record for one in ladder.blocked_records if one.is_fitted]
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
    if len(ladder.blocked_records) == 1:
        yield (
            "A log of another cadence (other rates, minor loops), given by --other: all blocks of one log share "
            "theirs, in which lag and hysteresis look alike."
        )


def _find_memory(check: Validation) -> float:
    return max(find_memory(check.record, errors) for errors in check.residuals.T)
