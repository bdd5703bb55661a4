"""What holds for the claims of every study, whatever they say."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, replace
from typing import Any

from martensite.scenario.citations import read_bibliography
from martensite.studies.base import GROUNDS, AbstractStudy, Answer, Claim
from martensite.studies.shipped_numbers import find_changes
from martensite.studies.tables import TableStudy


def check_complete(answer: Answer, *, all_computed: bool = True) -> None:
    """Every claim and report has all that it needs, under a name of its own, and goes into JSON."""
    both = [*answer.claims, *answer.reports]
    assert len({one.id for one in both}) == len(both)
    for one in both:
        assert one.statement and one.why and one.unit
        assert one.source.split(",")[0] in read_bibliography()
        bare = isinstance(one, Claim) and one.verdict == "not comparable"
        if (all_computed and not bare) or one.computed is not None:
            assert one.computed is not None and math.isfinite(one.computed)
    json.dumps(asdict(answer), allow_nan=False)


def check_shipped(study: AbstractStudy) -> None:
    """Check shipped numbers against computed ones, except searches whose end depends on the machine."""
    assert isinstance(study, TableStudy)
    assert find_changes(study, wandering=False) == []


def check_decides(claims: Iterable[Claim]) -> None:
    """The distance decides between reproduced and all else: just inside of the tolerance, and just outside."""
    bare = dict.fromkeys(GROUNDS.values(), "") | {"as_printed": None}
    for claim in claims:
        if claim.tolerance is None or claim.computed is None:
            continue
        printed = claim.published if claim.published is not None else claim.as_printed
        assert printed is not None
        far, near = printed + 1.01 * claim.tolerance + 1e-9, printed + 0.99 * claim.tolerance
        fields: dict[str, Any] = {**bare, "published": printed}
        assert replace(claim, **fields, computed=far, verdict="disagrees").verdict == "disagrees"
        assert replace(claim, **fields, computed=near, verdict="reproduced").verdict == "reproduced"


def verdicts_of(claims: Iterable[Claim]) -> dict[str, set[str]]:
    """The names of the claims of each verdict that there is."""
    found: dict[str, set[str]] = {}
    for claim in claims:
        found.setdefault(claim.verdict, set()).add(claim.id)
    return found


def numbers_of(answers: Sequence[Answer]) -> dict[str, float | None]:
    """Every computed number by its name, of claims and of reports."""
    return {one.id: one.computed for answer in answers for one in (*answer.claims, *answer.reports)}
