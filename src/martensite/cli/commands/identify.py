"""`identify LOG...`: identify a dynamic model from logs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer import Argument, Option

from martensite.base.errors import InputError, suggest_name
from martensite.base.files import replace_together
from martensite.base.interrupts import InterruptError, rescue_answer
from martensite.cli.app import app
from martensite.cli.options import (
    Imports,
    NamedColumns,
    Text,
    Texts,
    import_modules,
    read_positive,
    read_quantity,
    spread_options,
)
from martensite.cli.outputs import AnswerOptions, Outputs, check_absent, check_ending, check_folder
from martensite.cli.progress import show_share, show_spinner

if TYPE_CHECKING:
    from martensite.identify.chains.estimate import Options
    from martensite.identify.chains.stages import IdentifiedStages, ModelStage
    from martensite.identify.ladder.ladder_result import LadderTrial
    from martensite.signals.sampling.sampled import Sampled

REPORTS = (".html", ".md")
ANCHOR = 0.1
"""Weight of rest for a record that begins at rest, relative to all rows."""


@dataclass(frozen=True)
class IdentifyOptions:
    """Inputs, outputs and options of an identification."""

    inputs: Annotated[Texts, Option("--input", metavar="COLUMN", help="Input column, e.g. voltage; repeatable.")] = None
    output: Annotated[
        Text, Option(metavar="COLUMN", help="Output column, e.g. position; several separated by commas.")
    ] = None
    stage: Annotated[
        Texts,
        Option(
            metavar="BLOCKS[->COLUMN]",
            help=(
                'Blocks in series, e.g. "poly2 | oe(3,3,1) | pwl10". If repeated, each stage starts at the '
                "measured column that the stage before names."
            ),
        ),
    ] = None
    validate: Annotated[
        Texts,
        Option(metavar="LOG", help="Validation log, with another time scale, that selects the structure; repeatable."),
    ] = None
    other: Annotated[Texts, Option(metavar="LOG", help="Test log that is only scored; repeatable.")] = None
    interval: Annotated[
        Text, Option(help='Sample time of the model, e.g. "20 ms" [default: sample time of the log].')
    ] = None
    unit: Annotated[
        Texts, Option(metavar="COLUMN=UNIT", help='Unit of a column in the model, e.g. "duty=%"; repeatable.')
    ] = None
    starts: Annotated[int, Option(min=1, help="Number of searches from random starting points.")] = 12
    seed: Annotated[int, Option(min=0, help="Seed of the random starting points.")] = 0
    skip: Annotated[Text, Option(help='Time at the start of every log that is ignored, e.g. "2 s".')] = None
    initial: Annotated[
        str,
        Option(
            help=(
                "Initial state: rest, zero, estimate, or auto (test each log for a start at rest, and estimate "
                "otherwise)."
            )
        ),
    ] = "auto"
    anchor: Annotated[
        float | None,
        Option(
            min=0.0,
            help=(
                "Weight of the rows before the input first changes, 0 to 1 [default: 0.1 for logs that start at "
                "rest, otherwise 0]."
            ),
        ),
    ] = None
    time_box: Annotated[
        Text, Option(metavar="TIME", help='CPU time of the structure search, e.g. "60 s" [default: "120 s"].')
    ] = None
    ridge: Annotated[
        float | None,
        Option(
            min=0.0, help=("Ridge penalty of free parameters, e.g. 1e-6 [default: chosen for short logs, otherwise 0].")
        ),
    ] = None
    new_headings: NamedColumns = None

    def plan_stages(self) -> list[ModelStage]:
        """Return the stages."""
        from martensite.identify.chains.stages import ModelStage

        texts = list(self.stage or ())
        output = self.output or ""
        read = [ModelStage.read(text, output if k == len(texts) else None) for k, text in enumerate(texts, start=1)]
        if read[-1].outputs != ModelStage("", output).outputs:
            raise InputError(f"The last stage gives `{read[-1].output}`, but --output is `{output}`.")
        return read

    @property
    def climbs(self) -> bool:
        """Test whether the structure is to be searched."""
        return not self.stage

    def complete_columns(self, log: str) -> IdentifyOptions:
        """Return these options with input and output columns chosen from the first log."""
        from martensite.scenario.identify_logs import choose_columns

        given = self.list_inputs()
        arrows = [text.partition("->")[2].strip() for text in self.stage or ()]
        named = [name.strip() for arrow in arrows for name in arrow.split(",") if name.strip()]
        last = arrows[-1] if arrows else ""
        inputs, output = choose_columns(log, given, self.output or last or None, named, self.read_new_headings())
        return replace(self, inputs=inputs, output=output)

    def list_inputs(self) -> list[str]:
        """Return the given inputs."""
        return [name.strip() for text in self.inputs or () for name in text.split(",") if name.strip()]

    def read_records(self, fitted: Sequence[str], outputs: Sequence[str]) -> tuple[list[Sampled], ...]:
        """Return the records for fit, validation and test, with one sample time."""
        from martensite.scenario.identify_logs import read_logs

        interval = read_positive("interval", self.interval, "s")
        groups: list[list[Sampled]] = []
        for logs in (fitted, self.validate or (), self.other or ()):
            group: list[Sampled] = []
            for log in logs:
                group += read_logs(
                    [log], self.inputs or [], outputs, interval, self.read_units(), self.read_new_headings()
                )
                interval = group[-1].interval
            groups.append(group)
        return tuple(groups)

    def read_new_headings(self) -> dict[str, str]:
        """Return the meanings of columns without headings."""
        from martensite.logs.reader import parse_new_headings

        return dict(parse_new_headings(self.new_headings or ()))

    def read_units(self) -> dict[str, str]:
        """Return units by column."""
        table: dict[str, str] = {}
        for text in self.unit or ():
            name, equals, spelling = text.partition("=")
            if not equals or not spelling.strip():
                raise InputError(f'`{text}` is no unit; write `COLUMN=UNIT`, e.g. "duty=%".')
            table[name.strip()] = spelling.strip()
        return table

    def choose_search(self, interval: float) -> Options:
        """Return the search options for a sample time [s]."""
        from martensite.identify.chains.estimate import Options
        from martensite.identify.chains.goals import AUTO
        from martensite.identify.chains.residuals import STARTS

        if self.initial not in (*STARTS, AUTO):
            raise InputError(f"Option `--initial` is `{self.initial}`. {suggest_name(self.initial, (*STARTS, AUTO))}")
        rest = ANCHOR if self.initial in ("rest", AUTO) else 0.0
        seconds = read_quantity("skip", self.skip, "s") or 0.0
        return Options(
            starts=self.starts,
            seed=self.seed,
            skip=max(round(seconds / interval), 0),
            start=self.initial,
            anchor=rest if self.anchor is None else self.anchor,
            ridge=self.ridge,
        )


@app.command("identify", rich_help_panel="From logs")
@spread_options
def identify(
    logs: Annotated[
        list[str],
        Argument(
            metavar="LOG...",
            help=(
                "Logs to fit together: text with headings such as `position [mm]`, .parquet, .mat or .nc; or "
                "data:SET/FILE."
            ),
        ),
    ],
    options: IdentifyOptions,
    answer: AnswerOptions,
    out: Annotated[Path | None, Option(metavar="MODEL", help="Model file to write: .json.")] = None,
    report: Annotated[Path | None, Option(metavar="PAGE", help="Report to write: .html or .md.")] = None,
    modules: Imports = None,
) -> None:
    """Identify a black-box model that predicts logs in free run.

    Columns are chosen by their names. The command tests initial rest, delay, order and linearity, and then tries
    structures from linear models to hysteresis, feedback and nonlinear state space. It keeps a structure if held-
    out blocks are predicted significantly better than by the structure before. The last fifth of the log tests the
    result, or the logs of --other. With --stage you give the structure; --input and --output are then optional if
    the log leaves no choice. Blocks: see `martensite list block`. All scores are of free runs, without feedback of
    measured outputs. The exit code is 1 if no structure predicts the log. Ctrl-C keeps the best model and gives
    exit code 130.
    """
    import_modules(modules)
    outputs = answer.check_files(out, ".json")
    if report is not None:
        check_ending(report, REPORTS)
        check_folder(report)
        check_absent(report, answer.force)
    if options.climbs:
        _climb(logs, options, answer, outputs, report)
        return
    options = options.complete_columns(logs[0])
    stages = options.plan_stages()
    with show_spinner("reading logs"):
        names = list(dict.fromkeys(name for stage in stages for name in stage.outputs))
        fitted, validation, other = options.read_records(logs, names)
        search = options.choose_search(fitted[0].interval)
    from martensite.identify.chains.estimate import INTERRUPTED
    from martensite.identify.chains.stages import identify_stages
    from martensite.show.summaries.identification import summarise_identified
    from martensite.show.terminal import print_summary

    ended: list[str] = []
    with show_share("identifying") as bar:

        def tell(text: str, share: float) -> None:
            if INTERRUPTED in text:
                ended.append(text)
            if bar is not None:
                bar(text, share)

        identified = identify_stages(fitted, stages, validation, other, search, tell)
    records = [*fitted, *validation, *other]
    written = _write_files(identified, outputs, records)
    if report is not None:
        written += _write_stages_report(identified, records, report)
    print_summary(summarise_identified(identified, records), answer.json, written)
    if ended:
        typer.echo("interrupted: this is the best so far", err=True)
        raise typer.Exit(InterruptError.exit_code)


def _climb(
    logs: list[str], options: IdentifyOptions, answer: AnswerOptions, outputs: Outputs, report: Path | None
) -> None:
    """Search for a structure; write files, print the summary and exit with a code."""
    from martensite.identify.ladder.climb import TIME_BOX
    from martensite.scenario.identify_logs import identify_log
    from martensite.scenario.model_files import write_model
    from martensite.show.pages import write_page
    from martensite.show.summaries.ladder import summarise_ladder
    from martensite.show.terminal import print_summary

    interval = read_positive("interval", options.interval, "s")
    best: list[LadderTrial] = []
    with rescue_answer(lambda: _save_best(best, outputs.data)), show_share("identifying") as bar:
        ladder = identify_log(
            logs,
            options.list_inputs(),
            options.output,
            validation=options.validate or (),
            other=options.other or (),
            interval=interval,
            units=options.read_units(),
            new_headings=options.read_new_headings(),
            options=replace(options.choose_search(interval or 1.0), ridge=options.ridge or 0.0),
            time_box=read_positive("time-box", options.time_box, "s") or TIME_BOX,
            watch=bar,
            keep=best.append,
        )
    summary, written = summarise_ladder(ladder), outputs.paths()
    if outputs.data is not None:
        write_model(ladder.model, outputs.data, {"ladder": summary.data["rungs"], "verdict": ladder.verdict})
    if outputs.figure is not None and ladder.checks:
        from martensite.show.figures.model import plot_model
        from martensite.show.figures.style import write_figure

        write_figure(plot_model(ladder.checks[0]), outputs.figure)
    if report is not None:
        written += write_page(summary, report)
    print_summary(summary, answer.json, written)
    if ladder.stop_reason == "interrupted":
        raise typer.Exit(InterruptError.exit_code)
    if ladder.doubts or not ladder.predicts:
        raise typer.Exit(1)


def _save_best(best: Sequence[LadderTrial], path: Path | None) -> str:
    """Write the best model of an interrupted search; return a sentence, or "" if there is none."""
    from martensite.scenario.model_files import write_model

    one = best[-1] if best else None
    if one is None or one.chain is None:
        return ""
    sentence = f"Interrupted; the best so far is `{one.structure}`, fit {one.held_out.fit:.1f} % on held-out data"
    if path is None:
        return f"{sentence}; use --out to keep it."
    write_model(one.chain, path)
    return f"{sentence}, saved in `{path}`."


def _write_stages_report(identification: IdentifiedStages, records: Sequence[Sampled], report: Path) -> list[Path]:
    from martensite.identify.chains.validation import validate_chain
    from martensite.show.pages import write_model_report
    from martensite.signals.sampling.resampling import select_signals

    names = identification.stages[-1].outputs
    own = [select_signals(record, identification.model.input_names, names) for record in records]
    checked = [validate_chain(identification.model, one, identification.options.skip) for one in own]
    return write_model_report(
        checked, report, identification.estimates[0].uncertainty if len(identification.stages) == 1 else None
    )


def _write_files(identification: IdentifiedStages, outputs: Outputs, records: Sequence[Sampled]) -> list[Path]:
    written = outputs.paths()
    with replace_together():
        if outputs.data is not None:
            _save_model(identification, outputs.data)
        if outputs.figure is not None:
            from martensite.show.figures.model import plot_identified
            from martensite.show.figures.style import write_figure

            write_figure(plot_identified(identification, records), outputs.figure)
    if outputs.data is not None and len(identification.estimates) > 1:
        for k, one in enumerate(identification.estimates, start=1):
            from martensite.scenario.model_files import model_provenance, write_model

            beside = outputs.data.with_name(f"{outputs.data.stem}.stage{k}.json")
            write_model(one.chain, beside, model_provenance(one))
            written.append(beside)
    return written


def _save_model(identification: IdentifiedStages, path: Path) -> None:
    from dataclasses import asdict

    from martensite.scenario.model_files import model_provenance, write_model

    stages = [model_provenance(one) for one in identification.estimates]
    origin = stages[0] if len(stages) == 1 else {"stages": stages}
    scores = [asdict(score) for score in identification.scores]
    write_model(identification.model, path, origin | {"scores_of_free_runs": scores})
