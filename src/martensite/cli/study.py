"""`study`: published results rebuilt, each claim with its number and its verdict."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from martensite.cli.app import app
from martensite.cli.options import Json
from martensite.cli.waiting import spinner

if TYPE_CHECKING:
    from martensite.studies.base import AbstractStudy, Claim

COLOURS = {"reproduced": "green", "not reproduced": "red", "calibrated": "yellow"}


@app.command()
def study(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME]...", help="Studies, or `all`; without one they are listed."),
    ] = None,
    figures: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Write the figure of each study into this folder."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace existing figures.")] = False,
    json: Json = False,
) -> None:
    """List the studies, or rebuild one: claims, numbers, verdicts."""
    from martensite.cli import show
    from martensite.studies.base import load_study, study_names

    if not names:
        _list_studies(json)
        return
    found = [load_study(name) for name in (study_names() if names == ["all"] else names)]
    drawn = _figures(found, figures, force)
    reports: list[dict[str, Any]] = []
    for one in found:
        with spinner(f"computing {one.key}"):
            claims = one.claims()
        if not json:
            print_claims(one, claims)
        reports.append(_report(one, claims))
        if one.key in drawn:
            with spinner(f"drawing {one.key}"):
                one.figure(drawn[one.key])
            if not json:
                show.text(f"wrote {drawn[one.key]}")
    if json:
        show.as_json(reports)


def _list_studies(json: bool) -> None:
    """All studies with a line each; none is computed."""
    from martensite.cli import show
    from martensite.studies.base import load_study, study_names

    found = [load_study(name) for name in study_names()]
    if json:
        show.as_json([{"key": one.key, "title": one.title} for one in found])
        return
    show.table(("study", "what is rebuilt"), [(one.key, one.title) for one in found])
    show.text("martensite study NAME computes its claims; `all` takes all of them.")


def _figures(studies: list[AbstractStudy], folder: Path | None, force: bool) -> dict[str, Path]:
    """File of each figure, checked before anything is computed."""
    from martensite.cli.outputs import Outputs

    if folder is None:
        return {}
    found = {one.key: folder / f"{one.key}.png" for one in studies}
    for path in found.values():
        Outputs(None, path).check(force)
    return found


def _report(study: AbstractStudy, claims: list[Claim]) -> dict[str, Any]:
    return {
        "key": study.key,
        "title": study.title,
        "cites": list(study.cites),
        "claims": [claim.to_dict() for claim in claims],
    }


def print_claims(study: AbstractStudy, claims: list[Claim], *, brief: bool = False) -> None:
    """Print the claims of a study as a table, and how many there are of each verdict.

    The brief table holds the claims for which the source prints a number, without reasons.
    """
    from collections import Counter

    from martensite.cli import show

    shown = [claim for claim in claims if claim.published is not None or not brief]
    columns = ("claim", "published", "computed", "tolerance", "unit", "verdict")
    show.text(f"{study.key}: {study.title}", "bold")
    show.table(
        columns if brief else (*columns, "source", "why"),
        [_row(claim)[: len(columns)] if brief else _row(claim) for claim in shown],
        right="published,computed,tolerance",
        colours={"verdict": COLOURS},
    )
    counted = Counter(claim.verdict for claim in claims)
    show.text(", ".join(f"{count} {verdict}" for verdict, count in counted.items()))


def _row(claim: Claim) -> tuple[str, ...]:
    numbers = (claim.published, claim.computed, claim.tolerance)
    cells = ("" if number is None else f"{number:.4g}" for number in numbers)
    return (f"{claim.id}: {claim.statement}", *cells, claim.unit, claim.verdict,
            claim.source, claim.why)  # fmt: skip
