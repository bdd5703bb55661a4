"""Validation of a chain on a record: size, place and content of its errors.

All figures belong to a free run from an initial state. Use a record that no fit has used, with another excitation: lag
and hysteresis cannot be distinguished at a single pulse rate.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from martensite.base.errors import DataError
from martensite.identify.blocks.base import Numbers
from martensite.identify.chains.chain import Chain
from martensite.identify.chains.correlations import LEVEL, CrossCorrelation, correlate_residuals
from martensite.identify.chains.goals import AUTO
from martensite.identify.chains.record_parts import (
    REVERSAL,
    ErrorStretch,
    Masks,
    known_stretch,
    split_by_direction,
    summarise_segments,
)
from martensite.identify.chains.record_starts import RunStart, find_start
from martensite.identify.chains.scores import run_from
from martensite.search.model_score import Score, score_model
from martensite.search.quantity_text import format_number, join_phrases
from martensite.search.whiteness import LEAST_SAMPLES, Whiteness, assess_whiteness
from martensite.signals.sampling.sampled import Sampled

WHOLE = "whole"
"""Name of the score of all samples."""
UNEVEN = 2.0
"""Ratio of errors in two parts of a record that is reported."""
BIASED = 0.5
"""Fraction of the error that is a constant offset, above which it is reported."""


@dataclass(frozen=True, eq=False)
class Validation:
    """A chain on a record."""

    chain: Chain
    record: Sampled
    outputs: Numbers
    """Outputs of the chain, shape (samples, outputs)."""
    skip: int
    parts: dict[str, Numbers]
    scores: tuple[Score, ...]
    stretches: tuple[ErrorStretch, ...]
    whiteness: tuple[Whiteness, ...]
    correlations: tuple[CrossCorrelation, ...]
    begins: str
    state: Numbers | None = None
    """State at the first sample; None for a steady start."""

    @property
    def residuals(self) -> Numbers:
        """Return measured less computed outputs, NaN where not counted."""
        errors = self.record.outputs - self.outputs
        errors[: self.skip] = np.nan
        return errors

    def score(self, output: str | None = None, part: str = WHOLE) -> Score:
        """Return the score of an output (default: the first) in a part; raise `DataError` if there is none."""
        name = self.record.output_names[0] if output is None else output
        for one in self.scores:
            if one.output == name and one.part == part:
                return one
        raise DataError(f"There is no score of `{name}` in part `{part}`.")

    @property
    def fit(self) -> float:
        """Return the mean NRMSE fit of all outputs [%]."""
        whole = [one.fit_percent for one in self.scores if one.part == WHOLE]
        return float(np.mean(whole))

    def best(self, output: str | None = None) -> ErrorStretch:
        """Return the stretch with the smallest error."""
        return min(self._own(output), key=lambda one: one.rms)

    def worst(self, output: str | None = None) -> ErrorStretch:
        """Return the stretch with the largest error."""
        return max(self._own(output), key=lambda one: one.rms)

    @property
    def explained(self) -> bool:
        """Return whether the residuals are uncorrelated with all inputs."""
        return all(one.explained for one in self.correlations)

    @property
    def failures(self) -> tuple[str, ...]:
        """Return the failed checks, one sentence each."""
        failures = [one.sentence for one in self.correlations if not one.explained]
        for name in self.record.output_names:
            failures += self._offset(name)
            failures += self._unequal(name)
        return tuple(failures)

    @property
    def sentences(self) -> tuple[str, ...]:
        """Return scores, failed checks, and whiteness as sentences."""
        whole = [self._score_outputs(one) for one in self.scores]
        good = () if self.failures else ("The tests find nothing that the model misses.",)
        begins = f"Initial state of `{self.record.name}`: {self.begins}."
        return (*whole, begins, *self.failures, *good, *(one.sentence for one in self.whiteness))

    def to_dict(self) -> dict[str, Any]:
        """Return all figures and sentences by name, for JSON."""
        return {
            "record": self.record.name,
            "skip": self.skip,
            "begins": self.begins,
            "fit_percent": self.fit,
            "scores": [one.to_dict() for one in self.scores],
            "stretches": [one.to_dict() for one in self.stretches],
            "whiteness": [one.to_dict() for one in self.whiteness],
            "crossed": [one.to_dict() for one in self.correlations],
            "failures": list(self.failures),
        }

    def _own(self, output: str | None) -> list[ErrorStretch]:
        name = self.record.output_names[0] if output is None else output
        return [one for one in self.stretches if one.output == name]

    def _unit(self, output: str) -> str:
        unit = self.record.units.get(output, "")
        return "" if unit in ("", "1") else f" {unit}"

    def _score_outputs(self, one: Score) -> str:
        unit = self._unit(one.output)
        return (
            f"`{one.record}`, `{one.output}` ({one.part}, free run): fit {one.fit_percent:.2f} %, "
            f"rms error {format_number(one.rms, 3)}{unit}, at most "
            f"{format_number(one.maximum, 3)}{unit} at {format_number(one.maximum_at)} s."
        )

    def _offset(self, output: str) -> list[str]:
        one = self.score(output)
        if not abs(one.bias) > BIASED * one.rms:
            return []
        unit = self._unit(output)
        return [
            f"`{output}` is off by a constant {format_number(one.bias, 2)}{unit} (computed less "
            f"measured), most of its rms error of {format_number(one.rms, 2)}{unit}; check the "
            "output at rest and the operating range."
        ]

    def _unequal(self, output: str) -> list[str]:
        parts = [one for one in self.scores if one.output == output and one.part != WHOLE]
        if len(parts) < 2:
            return []
        good, bad = min(parts, key=lambda s: s.rms), max(parts, key=lambda s: s.rms)
        if not bad.rms > UNEVEN * good.rms:
            return []
        unit = self._unit(output)
        return [
            f"The error of `{output}` is uneven: rms {format_number(bad.rms, 2)}{unit} while "
            f"{bad.part}, {format_number(good.rms, 2)}{unit} while {good.part}; a model whose two "
            "directions differ needs a block with hysteresis."
        ]


def validate_chain(
    chain: Chain,
    record: Sampled,
    skip: int = 0,
    masks: Masks | None = None,
    *,
    reversal: float = REVERSAL,
    level: float = LEVEL,
    state: Numbers | None = None,
) -> Validation:
    """Run a chain along a record and test its errors.

    Args:
        chain: the model.
        record: measurements; missing outputs do not count.
        skip: samples at the start that do not count.
        masks: masks of samples by name for scores of parts; default: rising and falling first input.
        reversal: return of an input after a turning point, as a fraction of its range.
        level: confidence level of the tests of correlation.
        state: state at the first sample; default: `record_starts.find_start`.

    Raises:
        DataError: an output has fewer than 10 counted samples, or a mask does not fit.
        InputError: the record does not fit the model.
    """
    begin = find_start(chain, record, AUTO, skip) if state is None else RunStart(state, "as given")
    computed = run_from(chain, record, begin)
    if computed.shape != record.outputs.shape:
        raise DataError(
            f"Model `{chain.name}` has {computed.shape[1]} outputs, but record `{record.name}` "
            f"{record.outputs.shape[1]}."
        )
    if not np.all(np.isfinite(computed)):
        raise DataError(f"Model `{chain.name}` does not stay finite along `{record.name}`.")
    parts = split_by_direction(record, masks, reversal=reversal)
    whole = {WHOLE: np.ones(len(record), dtype=bool), **parts}
    residuals = record.outputs - computed
    residuals[:skip] = np.nan
    return Validation(
        chain,
        record,
        computed,
        skip,
        parts,
        tuple(_score_parts(record, computed, skip, whole)),
        tuple(
            one
            for k, name in enumerate(record.output_names)
            for one in summarise_segments(record.times, residuals[:, k], name)
        ),
        tuple(_test_whiteness(record, residuals)),
        tuple(_test_correlation(record, residuals, level)),
        begin.description,
        begin.state,
    )


def _score_parts(record: Sampled, computed: Numbers, skip: int, parts: dict[str, Numbers]) -> Iterable[Score]:
    late = np.arange(len(record)) >= skip
    for k, output in enumerate(record.output_names):
        y = record.outputs[:, k]
        counted = late & np.isfinite(y)
        if counted.sum() < LEAST_SAMPLES:
            raise DataError(
                f"Output `{output}` of record `{record.name}` has {int(counted.sum())} samples "
                f"that count, but a validation takes at least {LEAST_SAMPLES}."
            )
        for part, mask in parts.items():
            chosen = counted & mask
            if chosen.any():
                yield score_model(
                    record.times[chosen],
                    y[chosen],
                    computed[chosen, k],
                    record=record.name,
                    output=output,
                    unit=record.units.get(output, "1"),
                    part=part,
                )


def _test_whiteness(record: Sampled, residuals: Numbers) -> Iterable[Whiteness]:
    for k, output in enumerate(record.output_names):
        piece = residuals[known_stretch(residuals[:, k]), k]
        if len(piece) >= LEAST_SAMPLES:
            yield assess_whiteness(piece, f"{record.name}, {output}")


def _test_correlation(record: Sampled, residuals: Numbers, level: float) -> Iterable[CrossCorrelation]:
    for k, output in enumerate(record.output_names):
        for i, input_name in enumerate(record.input_names):
            u = record.inputs[:, i]
            middle = u - u.mean()
            for name, signal in ((f"`{input_name}`", middle), (f"`{input_name}`²", middle**2)):
                correlation = correlate_residuals(
                    residuals[:, k], signal, record.interval, output=output, name=name, level=level
                )
                if correlation is not None:
                    yield correlation


def compare_validations(validations: Iterable[Validation]) -> str:
    """Return the best and worst of several records as a sentence; raise `DataError` for none."""
    ranked = sorted(validations, key=lambda one: one.fit)
    if not ranked:
        raise DataError("There are no validations to compare.")
    fits = [one.fit for one in ranked]
    names = join_phrases([f"`{one.record.name}` {one.fit:.2f} %" for one in (ranked[-1], ranked[0])])
    return f"{len(ranked)} records: median fit {np.median(fits):.2f} %; best and worst {names}."
