"""`study`: published results rebuilt, each claim with its number and its verdict; `demo`: one of them."""

from __future__ import annotations

from collections import Counter
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from martensite.base.interrupts import rescue_answer
from martensite.base.summary import DataTable, Sentence, Summary, Tone
from martensite.cli.app import app
from martensite.cli.options import Json
from martensite.cli.outputs import Outputs
from martensite.cli.progress import show_spinner

if TYPE_CHECKING:
    from martensite.studies.base import AbstractStudy, Claim

COLUMNS = ("claim", "published", "computed", "tolerance", "unit", "verdict", "source", "why")
BRIEF = 6
"""Columns without reasons."""
TONES: dict[str, Tone] = {"reproduced": "good", "not reproduced": "bad", "calibrated": "caution"}
DEMONSTRATED = "migaone"


@app.command()
def study(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help="Studies, or `all`; without one they are listed.")
    ] = None,
    figures: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Write the figure of each study into this folder.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace existing figures.")] = False,
    json: Json = False,
) -> None:
    """List the studies, or rebuild one: claims, numbers, verdicts."""
    from martensite.show.terminal import print_json, print_summary
    from martensite.studies.base import load_study, study_names

    if not names:
        print_summary(_summarise_all([load_study(name) for name in study_names()]), json)
        return
    found = [load_study(name) for name in (study_names() if names == ["all"] else names)]
    drawn = _check_figures(found, figures, force)
    reports: list[dict[str, Any]] = []
    for one in found:
        done = f"Interrupted in `{one.key}`, after {len(reports)} of {len(found)} studies."
        with rescue_answer(partial(str, done)), show_spinner(f"computing {one.key}"):
            summary = summarise_claims(one, one.claims())
        reports.append(summary.data)
        if not json:
            print_summary(summary)
        if one.key in drawn:
            with show_spinner(f"drawing {one.key}"):
                one.figure(drawn[one.key])
            if not json:
                typer.echo(f"wrote {drawn[one.key]}")
    if json:
        print_json(reports)


def _summarise_all(found: list[AbstractStudy]) -> Summary:
    table = DataTable(("study", "what is rebuilt"), [(one.key, one.title) for one in found])
    told = Sentence("martensite study NAME computes its claims; `all` takes all of them.")
    return Summary("", [table, told], [{"key": one.key, "title": one.title} for one in found])


def _check_figures(studies: list[AbstractStudy], folder: Path | None, force: bool) -> dict[str, Path]:
    if folder is None:
        return {}
    found = {one.key: folder / f"{one.key}.png" for one in studies}
    for path in found.values():
        Outputs(None, path).check(force)
    return found


def summarise_claims(study: AbstractStudy, claims: list[Claim], *, brief: bool = False) -> Summary:
    """The claims of a study as a table, and how many there are of each verdict.

    The brief table holds the claims for which the source prints a number, without reasons.
    """
    shown = [claim for claim in claims if claim.published is not None or not brief]
    head = COLUMNS[:BRIEF] if brief else COLUMNS
    rows = [_write_claim(claim)[: len(head)] for claim in shown]
    counted = Counter(claim.verdict for claim in claims)
    blocks = [
        DataTable(head, rows, right=(1, 2, 3), tones=TONES),
        Sentence(", ".join(f"{count} {verdict}" for verdict, count in counted.items())),
    ]
    data = {
        "key": study.key,
        "title": study.title,
        "cites": list(study.cites),
        "claims": [claim.to_dict() for claim in claims],
    }
    return Summary(f"{study.key}: {study.title}", blocks, data)


def _write_claim(claim: Claim) -> tuple[str, ...]:
    numbers = (claim.published, claim.computed, claim.tolerance)
    cells = ("" if number is None else f"{number:.4g}" for number in numbers)
    own = claim.unit, claim.verdict, claim.source, claim.why
    return f"{claim.id}: {claim.statement}", *cells, *own


@app.command()
def demo(json: Json = False) -> None:
    """Rebuild a published test; writes migaone.nc and migaone.png.

    Where its study is installed, the claims of the source follow.
    """
    from martensite.cli.outputs import Outputs
    from martensite.cli.run import RunOptions, run_scenario
    from martensite.scenario.examples import EXAMPLES
    from martensite.scenario.scenario import load
    from martensite.show.terminal import print_json, print_summary
    from martensite.studies.base import INSTALLATION, STUDIES

    outputs = Outputs(Path(f"{DEMONSTRATED}.nc"), Path(f"{DEMONSTRATED}.png")).check(force=True)
    _, done = run_scenario(load(EXAMPLES / f"{DEMONSTRATED}.toml"), RunOptions(), outputs)
    claims = None
    if DEMONSTRATED in STUDIES.names():
        study = STUDIES[DEMONSTRATED]()
        claims = summarise_claims(study, study.claims(), brief=True)
    if json:
        files = [str(path) for path in outputs.paths()]
        run = done.data | {"files": files}
        print_json({"run": run, "claims": claims.data["claims"] if claims else None})
        return
    print_summary(done, files=outputs.paths())
    typer.echo()
    if claims is None:
        typer.echo(f"The claims of its source are a study; {INSTALLATION}.")
        return
    print_summary(claims)
    count = len(claims.data["claims"])
    typer.echo(f"All {count} claims with their reasons: martensite study {DEMONSTRATED}")
