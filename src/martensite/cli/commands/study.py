"""`study` and `demo`: reproduced results of publications."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from functools import partial
from itertools import groupby
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Annotated, Any

import typer

from martensite.base.formats import typeset_unit
from martensite.base.interrupts import rescue_answer
from martensite.base.summary import PAGE_WIDTH, Block, DataTable, Sentence, Summary, Tone
from martensite.cli.app import app
from martensite.cli.options import Json
from martensite.cli.outputs import Outputs
from martensite.cli.progress import show_spinner

if TYPE_CHECKING:
    from martensite.studies.base import AbstractStudy, Answer

DIGEST = {
    "holds": "Reproduced",
    "misprinted": "Misprints",
    "contradicts_itself": "Contradictions",
    "assumed": "Assumptions",
    "use_instead": "Recommended",
}
"""Labels of verdicts in the summary."""
COUNTED = {
    "disagrees": ("disagrees", "disagree"),
    "misprint": ("misprint", "misprints"),
    "self-contradictory": ("contradiction", "contradictions"),
    "recovery": ("recovered value", "recovered values"),
    "reports": ("reported value", "reported values"),
}
"""Singular and plural of verdicts, if they differ from the verdict itself."""
TONES: dict[str, Tone] = {"reproduced": "good", "disagrees": "bad"}
HEADS = ("repro-\nduced", "dis-\nagrees", "mis-\nprint", "contra-\ndictory", "not\ncomp.", "reco-\nvery", "re-\nports")
"""Headings of narrow columns, in the order of the verdicts."""
DEMONSTRATED = "migaone"


@app.command("study", rich_help_panel="Simulate")
def study(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME]...", help="Names of studies, or all [default: list of the studies]."),
    ] = None,
    reasons: Annotated[
        bool, typer.Option("--all", help="Show the reasons of all verdicts, and reported values.")
    ] = False,
    recompute: Annotated[
        bool, typer.Option("--recompute", help="Compute all values again, which takes up to minutes.")
    ] = False,
    figures: Annotated[Path | None, typer.Option(metavar="FOLDER", help="Folder for the figure of each study.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite existing figures.")] = False,
    json: Json = False,
) -> None:
    """List studies, or show the claims and verdicts of one.

    A study that fails is reported on standard error, and the others continue. If a study fails, the exit code is 1.
    """
    from martensite.show.terminal import print_json, print_summary
    from martensite.studies.base import load_studies, load_study

    everything = not names or names == ["all"]
    studies, failures = load_studies() if everything else ([load_study(name) for name in names or ()], [])
    if not names:
        print_summary(_summarise_all(studies, failures), json)
    else:
        figure_paths = {} if figures is None else {one.key: figures / f"{one.key}.png" for one in studies}
        for path in figure_paths.values():
            Outputs(None, path).check(force)
        summaries: list[Any] = []
        for one in studies:
            done = f"Interrupted in `{one.key}`, after {len(summaries)} of {len(studies)} studies."
            with rescue_answer(partial(str, done)), _note_failure(one, failures, alone=len(studies) == 1):
                summaries.append(_show_study(one, reasons, recompute, json, figure_paths.get(one.key)))
        if json:
            print_json(summaries)
    for failure in failures:
        typer.secho(f"error: {failure}", fg=typer.colors.RED, err=True)
    if names and failures:
        raise typer.Exit(1)


@contextmanager
def _note_failure(study: AbstractStudy, failures: list[str], *, alone: bool) -> Iterator[None]:
    """Note the failure of one of several studies; re-raise that of a single one."""
    from martensite.studies.base import describe_failure

    try:
        yield
    except Exception as error:  # a half-written study may raise anything
        if alone:
            raise
        failures.append(describe_failure(study.key, error))


def _show_study(study: AbstractStudy, reasons: bool, recompute: bool, json: bool, figure: Path | None) -> Any:
    from martensite.show.terminal import print_summary

    with show_spinner(f"computing {study.key}"):
        summary = summarise_answer(study, study.find_answer(recompute), reasons=reasons)
    if not json:
        print_summary(summary)
    if figure is not None:
        with show_spinner(f"drawing {study.key}"):
            study.figure(figure)
        if not json:
            typer.echo(f"wrote {figure}")
    return summary.data


def _summarise_all(studies: list[AbstractStudy], failures: list[str]) -> Summary:
    """Count the claims of each verdict by study and source."""
    from martensite.studies.base import VERDICTS

    tallies: dict[str, Counter[str]] = {}
    for one in studies:
        with _note_failure(one, failures, alone=False):
            tallies[one.key] = Counter(shipped.count_all() if (shipped := one.load_shipped_answer()) else ())
    entries = [one for one in studies if one.key in tallies]
    rows: dict[str, Counter[str]] = {}
    for source, group in groupby(entries, lambda one: (*one.cites, one.key)[0]):
        counts = {one.key: tallies[one.key] for one in group}
        rows |= counts if len(counts) == 1 else counts | {f"all of {source}": sum(counts.values(), Counter[str]())}
    blocks: list[Block] = [
        DataTable(("study", "subject"), [(one.key, one.title) for one in entries]),
        DataTable(
            ("claims and reports", *HEADS),
            [(name, *(str(count[kind]) for kind in (*VERDICTS, "reports"))) for name, count in rows.items()],
            right=range(1, len(HEADS) + 1),
        ),
        Sentence("Next: martensite study NAME shows one study, martensite study all shows all."),
    ]
    return Summary("", blocks, [{"key": one.key, "title": one.title, "tally": rows[one.key]} for one in entries])


def summarise_answer(study: AbstractStudy, answer: Answer, *, claims: bool = True, reasons: bool = False) -> Summary:
    """Return digest, counts of verdicts, claims, reasons and reports of a study."""
    counts = answer.count_all()
    counted = ", ".join(f"{count} {_name_count(kind, count)}" for kind, count in counts.items() if count)
    checked = sum(counts.values()) - counts.get("reports", 0)
    blocks: list[Block] = [
        *map(Sentence, wrap(f"{checked} claims checked: {counted}.", PAGE_WIDTH)),
        DataTable(("", "summary"), [(DIGEST.get(key, key), text) for key, text in answer.digest.items()]),
    ]
    if claims:
        rows = [
            (c.statement, _write(c.published, c.as_printed), _write(c.computed), typeset_unit(c.unit), c.verdict)
            for c in answer.claims
        ]
        blocks.append(DataTable(("claim", "published", "computed", "unit", "verdict"), rows, right=(1, 2), tones=TONES))
    if reasons:
        blocks.append(DataTable(("claim", "reason"), [(one.id, one.describe_reason()) for one in answer.claims]))
        rows = [(f"{one.id}: {one.statement}", _write(one.computed), one.unit, one.why) for one in answer.reports]
        blocks.append(DataTable(("reported value", "computed", "unit", "reason"), rows, right=(1,)))
    elif claims:
        blocks.append(Sentence(f"Next: martensite study {study.key} --all shows reasons and reported values."))
    if answer.made_by:
        blocks.append(Sentence(f"Computed by {answer.made_by}; --recompute computes them again."))
    data = {"key": study.key, "title": study.title, "cites": list(study.cites), "tally": answer.count_all()}
    return Summary("\n".join(wrap(study.title, PAGE_WIDTH)), blocks, data | asdict(answer))


def _name_count(kind: str, count: int) -> str:
    return COUNTED.get(kind, (kind, kind))[count > 1]


def _write(number: float | None, by_equation: float | None = None) -> str:
    """Format a number; one from a printed equation is in brackets."""
    return f"({by_equation:.4g})" if by_equation is not None else "" if number is None else f"{number:.4g}"


@app.command("demo", rich_help_panel="Simulate")
def demo(json: Json = False) -> None:
    """Rebuild a published test; write migaone.nc and migaone.png."""
    from martensite.cli.commands.run import RunOptions, run_scenario
    from martensite.scenario.examples import EXAMPLES
    from martensite.scenario.scenario import load
    from martensite.show.terminal import print_json, print_summary
    from martensite.studies.base import STUDIES

    outputs = Outputs(Path(f"{DEMONSTRATED}.nc"), Path(f"{DEMONSTRATED}.png")).check(force=True)
    _, done = run_scenario(load(EXAMPLES / f"{DEMONSTRATED}.toml"), RunOptions(), outputs)
    study = STUDIES[DEMONSTRATED]()
    digest = summarise_answer(study, study.find_answer(), claims=False)
    if json:
        run = done.data | {"files": [str(path) for path in outputs.paths()]}
        print_json({"run": run, "study": digest.data})
        return
    print_summary(done, files=outputs.paths(), wrap=True)
    typer.echo()
    print_summary(digest, wrap=True)
    typer.echo(f"Every claim with its numbers: martensite study {DEMONSTRATED}")
