"""Identified models: scores in free simulation, parameters, and warnings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from martensite.base.errors import DataError
from martensite.base.summary import Block, BulletList, DataTable, Heading, Notice, Picture, Sentence, Summary
from martensite.identify.blocks.base import AbstractStatic
from martensite.identify.chains.uncertainty import ChainUncertainty, measure_coverage
from martensite.identify.chains.validation import Validation, compare_validations
from martensite.search.quantity_text import format_number
from martensite.show.figures.model import plot_model, plot_model_loop, plot_model_tests
from martensite.show.figures.model_blocks import plot_linear_blocks, plot_static_blocks

if TYPE_CHECKING:
    from martensite.identify.chains.chain import Chain
    from martensite.identify.chains.estimate import ChainEstimate
    from martensite.identify.chains.stages import IdentifiedStages
    from martensite.signals.sampling.sampled import Sampled

ENOUGH = 3
"""Number of searches that should agree."""
MOST_NUMBERS = 12
"""Largest number of listed parameters of a chain."""
SCORES = ("model", "used for", "record", "output", "fit [%]", "RMS error", "largest error")
RECORD_SCORES = ("record", "output", "part", "fit [%]", "rms error", "largest error", "bias")


def summarise_identified(identification: IdentifiedStages, records: Sequence[Sampled]) -> Summary:
    """Return the summary of models in stages."""
    blocks = [block for k in range(len(identification.stages)) for block in _describe_stage(identification, k)]
    warned = [Sentence(one, "caution") for one in collect_warnings(identification, records)]
    return Summary("", [*blocks, *_describe_scores(identification), *warned], _collect_numbers(identification, records))


def _describe_stage(identification: IdentifiedStages, k: int) -> Iterator[Block]:
    stage, one = identification.stages[k], identification.estimates[k]
    chain = one.chain
    head = f"Stage {k + 1}" if len(identification.stages) > 1 else "Model"
    names = ", ".join(f"`{name}`" for name in chain.input_names)
    yield Heading(f"{head}: {names} -> `{stage.output}`: {chain.text()}")
    yield Sentence(
        f"{len(chain.theta)} free parameters, sample time {chain.interval:.6g} s, "
        f"{one.options.starts} starts; {one.agreeing} of {len(one.fits)} refined searches "
        "agree within 0.1 percentage points."
    )
    yield from _describe_dynamics(one)


def _describe_dynamics(one: ChainEstimate) -> Iterator[Block]:
    uncertainty = one.uncertainty
    blocks = enumerate(zip(one.chain.blocks, one.chain.split(), strict=True), start=1)
    errors = {(x.block, x.name): x.error for x in uncertainty.describe_numbers()} if uncertainty else {}
    rows = [
        (str(k), name, f"{value:.5g}", _format_error(errors.get((k, name), math.nan)), unit)
        for k, (block, theta) in blocks
        if block.states()
        for name, value, unit in block.describe_numbers(theta)
    ]
    if rows:
        yield DataTable(("block", "parameter", "value", "standard error", "unit"), rows[:MOST_NUMBERS], right=(2, 3))
    if len(rows) > MOST_NUMBERS:
        left = len(rows) - MOST_NUMBERS
        yield Sentence(f"{left} more parameters of dynamic blocks are in the output of --json.")
    yield from map(Sentence, uncertainty.sentences if uncertainty else ())


def _format_error(error: float) -> str:
    if math.isnan(error):
        return "–"
    return f"{error:.2g}" if math.isfinite(error) else "undetermined"


def _describe_scores(identification: IdentifiedStages) -> Iterator[Block]:
    yield Heading("Scores of free runs (no feedback of measured outputs)")
    rows = [
        (
            s.model,
            s.role,
            s.record,
            s.output,
            f"{s.fit:.2f}",
            *(f"{v:.4g} {_choose_difference_unit(s.unit)}".rstrip() for v in (s.rms, s.worst)),
        )
        for s in identification.scores
    ]
    yield DataTable(SCORES, rows, right=(4, 5, 6))
    yield from map(Sentence, _describe_starts(identification))


def _describe_starts(identification: IdentifiedStages) -> Iterator[str]:
    runs = [s for s in identification.scores if s.model in ("model", "series")]
    for start in dict.fromkeys(s.begins for s in runs):
        names = dict.fromkeys(f"`{s.record}`" for s in runs if s.begins == start)
        yield f"Initial state of {', '.join(names)}: {start}"


def _choose_difference_unit(unit: str) -> str:
    return {"degC": "K", "1": ""}.get(unit, unit)


def collect_warnings(identification: IdentifiedStages, records: Sequence[Sampled]) -> list[str]:
    """Return the warnings for users of a model."""
    entries = [f"{r.name}: {remark}" for r in records for remark in r.remarks]
    for one in identification.estimates:
        entries += one.remarks
        if one.options.starts > 1 and one.agreeing < ENOUGH:
            few = f"{one.agreeing} of {len(one.fits)} refined searches"
            entries.append(
                f"`{one.chain.text()}`: only {few} ended within 0.1 percentage points of the best, so the optimum may "
                "be local. Use more --starts."
            )
    roles = {score.role for score in identification.scores}
    if "validation" not in roles and "other" not in roles:
        entries.append(
            "Only fitted logs are scored, so the prediction error is unknown: a slow block can imitate hysteresis at "
            "one time scale. Use --validate with a log of another time scale, such as slow ramps with minor loops."
        )
    return entries


def _collect_numbers(identification: IdentifiedStages, records: Sequence[Sampled]) -> dict[str, Any]:
    stages = zip(identification.stages, identification.estimates, strict=True)
    return {
        "model": identification.model.text(),
        "interval": identification.model.interval,
        "free_run": True,
        "stages": [
            {
                "structure": one.chain.text(),
                "inputs": list(one.chain.input_names),
                "output": stage.output,
                "free_numbers": len(one.chain.theta),
                "numbers": dict(zip(one.chain.names(), map(float, one.chain.theta), strict=True)),
                "standard_errors": _list_errors(one),
                "refined_fits": [float(fit) for fit in one.fits],
                "agreeing": int(one.agreeing),
            }
            for stage, one in stages
        ],
        "scores": [asdict(score) for score in identification.scores],
        "warnings": collect_warnings(identification, records),
    }


def _list_errors(one: ChainEstimate) -> dict[str, float | None]:
    """Return the standard errors of the free numbers; None if undetermined."""
    errors = [] if one.uncertainty is None else one.uncertainty.errors.tolist()
    return {name: x if math.isfinite(x) else None for name, x in zip(one.chain.names(), errors, strict=False)}


def summarise_model(
    validations: Sequence[Validation], uncertainty: ChainUncertainty | None = None, title: str = ""
) -> Summary:
    """Return the scores of a model on records; `uncertainty` adds parameters and bands."""
    if not validations:
        raise DataError("A report on a model needs at least one validation.")
    chain = validations[0].chain
    lead = f"`{chain.text()}` at {chain.interval:.6g} s. {compare_validations(validations)}"
    blocks = list(_describe_model(chain, validations, uncertainty))
    return Summary(title or f"Model {chain.name}", blocks, lead=lead)


def _describe_model(
    chain: Chain, validations: Sequence[Validation], uncertainty: ChainUncertainty | None
) -> Iterator[Block]:
    yield Heading("Scores")
    yield Sentence("All scores are from free runs, without feedback of measured outputs.")
    rows = [row for one in validations for row in _score_rows(one)]
    yield DataTable(RECORD_SCORES, rows, right=(3, 4, 5, 6))
    for k, one in enumerate(validations):
        yield from _describe_record(k, one, uncertainty)
    if uncertainty is not None:
        yield from _describe_numbers(uncertainty)
    yield Heading("Blocks")
    if any(isinstance(block, AbstractStatic) for block in chain.blocks):
        yield Picture(
            "static",
            lambda: plot_static_blocks(chain, validations[0].record),
            "Static blocks over the range of their input (shaded).",
        )
    if any(block.linear for block in chain.blocks):
        yield Picture("linear", lambda: plot_linear_blocks(chain), "Linear blocks.")


def _score_rows(one: Validation) -> Iterator[tuple[str, ...]]:
    for score in one.scores:
        unit = one.record.units.get(score.output, "")
        sizes = (f"{format_number(v, 3)} {unit}".strip() for v in (score.rms, score.maximum, score.bias))
        yield score.record, score.output, score.part, f"{score.fit_percent:.2f}", *sizes


def _describe_record(k: int, one: Validation, uncertainty: ChainUncertainty | None) -> Iterator[Block]:
    yield Heading(f"Record {one.record.name}")
    faults = one.failures
    title = "Model error" if faults else "No model error found"
    yield Notice(title, faults or one.sentences[-2:-1], bool(faults))
    worst = one.worst()
    yield Sentence(
        f"The worst tenth of the record is from {format_number(worst.begin)} to {format_number(worst.end)} s, "
        f"with an rms error of {format_number(worst.rms, 3)}."
    )
    band = None if uncertainty is None else uncertainty.band(one.record, state=one.state)
    if band is not None:
        coverage = measure_coverage(band, one.record, one.skip)
        shares = ", ".join(f"{100.0 * share:.1f} %" for share in coverage)
        yield Sentence(f"The 95 % band contains {shares} of the samples.")
    yield Picture(f"record{k}", lambda: plot_model(one, band), "Measured and modelled data, with the error.")
    yield Picture(f"loop{k}", lambda: plot_model_loop(one), "Output over input.")
    yield Picture(
        f"tests{k}", lambda: plot_model_tests(one), "Autocorrelation of the residuals, and correlation with the inputs."
    )


def _describe_numbers(uncertainty: ChainUncertainty) -> Iterator[Block]:
    yield Heading("Parameters")
    yield BulletList(uncertainty.sentences)
    rows = [
        (str(one.block), one.name, format_number(one.value), format_number(one.error, 2), one.unit)
        for one in uncertainty.describe_numbers()
    ]
    yield DataTable(("block", "parameter", "value", "standard error", "unit"), rows, right=(2, 3))
