"""The run of `identify`: read logs, estimate, write, show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import typer

from martensite.base.errors import InputError, suggest_name
from martensite.cli.identify_columns import chosen
from martensite.cli.options import quantity
from martensite.cli.outputs import Outputs, parts
from martensite.cli.waiting import share_bar, spinner

if TYPE_CHECKING:
    from pathlib import Path

    from martensite.identify.chains.estimate import Options
    from martensite.identify.chains.stages import Identified, ModelStage
    from martensite.signals.sampling.sampled import Sampled

ANCHOR = 0.1
"""Weight of rest where a record begins there, in shares of all rows."""


@dataclass(frozen=True)
class Given:
    """What the command line says, as text."""

    logs: Sequence[str]
    inputs: Sequence[str]
    output: str | None
    stages: Sequence[str]
    search: str | None
    validate: Sequence[str]
    other: Sequence[str]
    interval: str | None
    units: Sequence[str]
    starts: int
    seed: int
    skip: str | None
    initial: str
    anchor: float | None
    ridge: float

    def planned(self) -> list[ModelStage]:
        """The stages.

        Raises:
            InputError: something is missing, or contradicts something else.
        """
        from martensite.identify.chains.stages import ModelStage

        if bool(self.stages) == (self.search is not None):
            raise InputError(
                "Identification needs --stage, blocks such as `poly2 | oe(3,3,1) | pwl10`, or "
                "--search, a pattern of them; give one of the two."
            )
        texts = [self.search] if self.search is not None else list(self.stages)
        output = self.output or ""
        read = [
            ModelStage.read(text, output if k == len(texts) else None)
            for k, text in enumerate(texts, start=1)
        ]
        if read[-1].outputs != ModelStage("", output).outputs:
            raise InputError(
                f"The last stage gives `{read[-1].output}`, but --output is `{output}`."
            )
        return read

    def completed(self) -> Given:
        """With the columns that the first log leaves no choice of.

        Raises:
            InputError: it leaves a choice.
        """
        given = [name.strip() for text in self.inputs for name in text.split(",") if name.strip()]
        arrows = [text.partition("->")[2].strip() for text in self.stages]
        named = [name.strip() for arrow in arrows for name in arrow.split(",") if name.strip()]
        last = arrows[-1] if arrows else ""
        inputs, output = chosen(self.logs[0], given, self.output or last or None, named)
        return replace(self, inputs=inputs, output=output)

    def records(self, outputs: Sequence[str]) -> tuple[list[Sampled], ...]:
        """Records to fit, to validate with, and others, all of one sample time."""
        interval = None if self.interval is None else quantity("interval", self.interval, "s")
        if interval is not None and not interval > 0.0:
            raise InputError(f"Option `--interval` must be above 0 s, but is {interval:g} s.")
        groups: list[list[Sampled]] = []
        for logs in (self.logs, self.validate, self.other):
            group: list[Sampled] = []
            for log in logs:
                record = self._read(log, outputs, interval)
                interval = record.interval
                group.append(record)
            groups.append(group)
        return tuple(groups)

    def _read(self, log: str, outputs: Sequence[str], interval: float | None) -> Sampled:
        from martensite.scenario.sampled_files import read_sampled

        return read_sampled(log, self.inputs, outputs, interval, self._units())

    def _units(self) -> dict[str, str]:
        found: dict[str, str] = {}
        for text in self.units:
            name, equals, spelling = text.partition("=")
            if not equals or not spelling.strip():
                raise InputError(f'`{text}` is no unit; write `COLUMN=UNIT`, e.g. "duty=%".')
            found[name.strip()] = spelling.strip()
        return found

    def options(self, interval: float) -> Options:
        """How stages are estimated at a sample time."""
        from martensite.identify.chains.estimate import Options
        from martensite.identify.chains.residuals import STARTS

        if self.initial not in STARTS:
            raise InputError(
                f"Option `--initial` is `{self.initial}`. {suggest_name(self.initial, STARTS)}"
            )
        rest = ANCHOR if self.initial == "rest" else 0.0
        seconds = 0.0 if self.skip is None else quantity("skip", self.skip, "s")
        return Options(
            starts=self.starts, seed=self.seed, skip=max(round(seconds / interval), 0),
            start=self.initial, anchor=rest if self.anchor is None else self.anchor,
            ridge=self.ridge,
        )  # fmt: skip


def run_identify(given: Given, outputs: Outputs, json: bool) -> bool:
    """Do what is asked for and show it; False if it was interrupted."""
    from martensite.cli import show
    from martensite.cli.identify_show import as_dict, print_identified

    given = given.completed()
    stages = given.planned()
    with spinner("reading logs"):
        names = list(dict.fromkeys(name for stage in stages for name in stage.outputs))
        fitted, validation, other = given.records(names)
        options = given.options(fitted[0].interval)
    from martensite.identify.chains.estimate import INTERRUPTED
    from martensite.identify.chains.stages import identify_stages

    ended: list[str] = []
    with share_bar("identifying") as bar:

        def tell(text: str, share: float) -> None:
            if INTERRUPTED in text:
                ended.append(text)
            if bar is not None:
                bar(text, share)

        found = identify_stages(fitted, stages, validation, other, options, tell)
    written = _write(found, outputs, [*fitted, *validation, *other])
    if json:
        show.as_json(as_dict(found, written, [*fitted, *validation, *other]))
    else:
        print_identified(found, written, [*fitted, *validation, *other])
    complete = not ended and all(s is None or s.complete for s in found.searches)
    if not complete:
        typer.echo("interrupted: this is the best so far", err=True)
    return complete


def _write(found: Identified, outputs: Outputs, records: Sequence[Sampled]) -> list[Path]:
    """Write model and figure; the files that were written."""
    written = outputs.paths()
    with parts(outputs) as files:
        if files.data is not None:
            _save(found, files.data)
        if files.figure is not None:
            from martensite.show.figures.files import write_figure
            from martensite.show.figures.identified import plot_identified

            write_figure(plot_identified(found, records), files.figure)
    if outputs.data is not None and len(found.estimates) > 1:
        for k, one in enumerate(found.estimates, start=1):
            from martensite.scenario.model_files import model_provenance, write_model

            beside = outputs.data.with_name(f"{outputs.data.stem}.stage{k}.json")
            write_model(one.chain, beside, model_provenance(one))
            written.append(beside)
    return written


def _save(found: Identified, path: Path) -> None:
    from dataclasses import asdict

    from martensite.scenario.model_files import model_provenance, write_model

    stages = [model_provenance(one) for one in found.estimates]
    origin = stages[0] if len(stages) == 1 else {"stages": stages}
    scores = [asdict(score) for score in found.scores]
    write_model(found.model, path, origin | {"scores_of_free_runs": scores})
