"""A model of blocks on records: scores, tests, uncertainty, figures.

Records are told apart as they are given; the ones that matter are those that no fit has seen, in
another cadence.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from martensite.base.errors import DataError
from martensite.base.summary import Block, BulletList, DataTable, Heading, Notice, Picture, Sentence, Summary
from martensite.identify.blocks.base import AbstractStatic
from martensite.identify.chains.uncertainty import ChainUncertainty, measure_coverage
from martensite.identify.chains.validation import Validation, compare_validations
from martensite.search.quantity_text import format_number
from martensite.show.figures.model import plot_model, plot_model_loop
from martensite.show.figures.model_blocks import plot_linear_blocks, plot_static_blocks
from martensite.show.figures.model_tests import plot_model_tests

if TYPE_CHECKING:
    from martensite.identify.chains.chain import Chain

SCORES = ("record", "output", "part", "fit [%]", "rms error", "largest error", "bias")


def summarise_model(
    validations: Sequence[Validation], uncertainty: ChainUncertainty | None = None, title: str = ""
) -> Summary:
    """How well a model does on records.

    Args:
        validations: the same model on one or several records.
        uncertainty: of the model; adds its numbers, and bands to the figures.
        title: headline; made from the name of the model if left out.

    Raises:
        DataError: there are no validations.
    """
    if not validations:
        raise DataError("A report on a model needs at least one validation.")
    chain = validations[0].chain
    lead = f"`{chain.text()}` at {chain.interval:.6g} s. {compare_validations(validations)}"
    blocks = list(_describe_model(chain, validations, uncertainty))
    return Summary(title or f"Model {chain.name}", blocks, lead=lead)


def _describe_model(chain: Chain, validations: Sequence[Validation], found: ChainUncertainty | None) -> Iterator[Block]:
    yield Heading("Scores")
    yield Sentence("All figures are those of free runs: no measured output enters.")
    rows = [row for one in validations for row in _score_rows(one)]
    yield DataTable(SCORES, rows, right=(3, 4, 5, 6))
    for k, one in enumerate(validations):
        yield from _describe_record(k, one, found)
    if found is not None:
        yield from _describe_numbers(found)
    yield Heading("Blocks")
    if any(isinstance(block, AbstractStatic) for block in chain.blocks):
        yield Picture(
            "static",
            lambda: plot_static_blocks(chain, validations[0].record),
            "Static blocks over what reached them (shaded).",
        )
    if any(block.linear for block in chain.blocks):
        yield Picture("linear", lambda: plot_linear_blocks(chain), "Linear blocks.")


def _score_rows(one: Validation) -> Iterator[tuple[str, ...]]:
    for score in one.scores:
        unit = one.record.units.get(score.output, "")
        sizes = (f"{format_number(v, 3)} {unit}".strip() for v in (score.rms, score.maximum, score.bias))
        yield score.record, score.output, score.part, f"{score.fit_percent:.2f}", *sizes


def _describe_record(k: int, one: Validation, found: ChainUncertainty | None) -> Iterator[Block]:
    yield Heading(f"Record {one.record.name}")
    faults = one.failures
    title = "What it misses" if faults else "Nothing found"
    yield Notice(title, faults or one.sentences[-2:-1], bool(faults))
    worst = one.worst()
    yield Sentence(
        f"The worst tenth is from {format_number(worst.begin)} to {format_number(worst.end)} s, "
        f"with an rms error of {format_number(worst.rms, 3)}."
    )
    band = None if found is None else found.band(one.record)
    if band is not None:
        held = measure_coverage(band, one.record, one.skip)
        shares = ", ".join(f"{100.0 * share:.1f} %" for share in held)
        yield Sentence(f"The band of 95 % holds {shares} of the samples.")
    yield Picture(f"record{k}", lambda: plot_model(one, band), "Measured and computed, with the error.")
    yield Picture(f"loop{k}", lambda: plot_model_loop(one), "Output over input.")
    yield Picture(f"tests{k}", lambda: plot_model_tests(one), "Residuals with themselves and the inputs.")


def _describe_numbers(found: ChainUncertainty) -> Iterator[Block]:
    yield Heading("Numbers")
    yield BulletList(found.sentences)
    rows = [
        (str(one.block), one.name, format_number(one.value), format_number(one.error, 2), one.unit)
        for one in found.describe_numbers()
    ]
    yield DataTable(("block", "number", "value", "standard error", "unit"), rows, right=(2, 3))
