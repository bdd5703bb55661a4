"""The report of a model of blocks on records: scores, tests, uncertainty, figures.

Records are told apart as they are given; the ones that matter are those that no fit has seen, in
another cadence.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from martensite.base.errors import DataError
from martensite.fit.fit_provenance import program
from martensite.identify.blocks.base import AbstractStatic
from martensite.identify.chains.uncertainty import ChainUncertainty, measure_coverage
from martensite.identify.chains.validation import Validation, compare_validations
from martensite.search.words import number
from martensite.show.figures.model import plot_model, plot_model_loop
from martensite.show.figures.model_blocks import plot_linear_blocks, plot_static_blocks
from martensite.show.figures.model_tests import plot_model_tests
from martensite.show.reports import html, markdown
from martensite.show.reports.blocks import Block, Bullets, Grid, Notice, Picture, Row, Section, Text
from martensite.show.reports.fit_report import (
    HTML,
    checked,
    figure_folder,
    write_figures,
    write_text,
)

if TYPE_CHECKING:
    from martensite.identify.chains.chain import Chain

SCORES = ("record", "output", "part", "fit [%]", "rms error", "largest error", "bias")


def write_model_report(
    validations: Sequence[Validation],
    path: str | Path,
    uncertainty: ChainUncertainty | None = None,
    title: str = "",
) -> None:
    """Write how well a model does on records; existing files are replaced.

    Args:
        validations: the same model on one or several records.
        path: the file to write: .html holds its figures, .md has them in the folder
            `NAME_figures` beside it. The folder of the path must exist.
        uncertainty: of the model; adds its numbers, and bands to the figures.
        title: headline; made from the name of the model if left out.

    Raises:
        DataError: there are no validations, or a file cannot be written.
    """
    path = checked(path)
    if not validations:
        raise DataError("A report on a model needs at least one validation.")
    chain = validations[0].chain
    blocks = list(_blocks(chain, validations, uncertainty))
    lead = f"`{chain.text()}` at {chain.interval:.6g} s. {compare_validations(validations)}"
    words = (title or f"Model {chain.name}", lead, blocks, f"Written by {program()}.")
    if path.suffix.lower() in HTML:
        write_text(path, html.page(*words))
    else:
        write_figures(figure_folder(path), blocks)
        write_text(path, markdown.page(*words, figure_folder(path).name))


def _blocks(
    chain: Chain, validations: Sequence[Validation], found: ChainUncertainty | None
) -> Iterator[Block]:
    yield Section("Scores")
    yield Text("All figures are those of free runs: no measured output enters.")
    yield Grid(SCORES, [row for one in validations for row in _scores(one)], right=(3, 4, 5, 6))
    for k, one in enumerate(validations):
        yield from _record(k, one, found)
    if found is not None:
        yield from _numbers(found)
    yield Section("Blocks")
    if any(isinstance(block, AbstractStatic) for block in chain.blocks):
        figure = plot_static_blocks(chain, validations[0].record)
        yield Picture("static", figure, "Static blocks over what reached them (shaded).")
    if any(block.linear for block in chain.blocks):
        yield Picture("linear", plot_linear_blocks(chain), "Linear blocks.")


def _scores(one: Validation) -> Iterator[Row]:
    for score in one.scores:
        unit = one.record.units.get(score.output, "")
        sizes = (f"{number(v, 3)} {unit}".strip() for v in (score.rms, score.maximum, score.bias))
        yield Row((score.record, score.output, score.part, f"{score.fit_percent:.2f}", *sizes))


def _record(k: int, one: Validation, found: ChainUncertainty | None) -> Iterator[Block]:
    yield Section(f"Record {one.record.name}")
    faults = one.failures
    yield Notice("What it misses" if faults else "Nothing found", faults or one.sentences[-2:-1],
                 bool(faults))  # fmt: skip
    worst = one.worst()
    yield Text(
        f"The worst tenth is from {number(worst.begin)} to {number(worst.end)} s, with an rms "
        f"error of {number(worst.rms, 3)}."
    )
    band = None if found is None else found.band(one.record)
    if band is not None:
        held = measure_coverage(band, one.record, one.skip)
        shares = ", ".join(f"{100.0 * share:.1f} %" for share in held)
        yield Text(f"The band of 95 % holds {shares} of the samples.")
    yield Picture(f"record{k}", plot_model(one, band), "Measured and computed, with the error.")
    yield Picture(f"loop{k}", plot_model_loop(one), "Output over input.")
    yield Picture(f"tests{k}", plot_model_tests(one), "Residuals with themselves and the inputs.")


def _numbers(found: ChainUncertainty) -> Iterator[Block]:
    yield Section("Numbers")
    yield Bullets(found.sentences)
    rows = [
        Row((str(one.block), one.name, number(one.value), number(one.error, 2), one.unit))
        for one in found.shown()
    ]
    yield Grid(("block", "number", "value", "standard error", "unit"), rows, right=(2, 3))
