"""What holds for the claims of every study, whatever they say."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from martensite.scenario.citations import read_bibliography
from martensite.studies.base import Claim
from martensite_studies.tables import TableStudy, settle_claims


def check_complete(claims: Sequence[Claim], *, all_computed: bool = True) -> None:
    """Every claim has all that it needs, under a name of its own, and goes into JSON."""
    assert len({claim.id for claim in claims}) == len(claims)
    for claim in claims:
        assert claim.statement and claim.why and claim.unit
        assert claim.source.split(",")[0] in read_bibliography()
        if all_computed or claim.computed is not None:
            assert claim.computed is not None and math.isfinite(claim.computed)
    json.dumps([claim.to_dict() for claim in claims], allow_nan=False)


def check_decides(claims: Iterable[Claim]) -> None:
    """The published number decides the verdict: just inside the tolerance, and just outside."""
    for claim in claims:
        fields = asdict(claim)
        del fields["verdict"]
        wrong = fields["computed"] + 1.01 * fields["tolerance"] + 1e-9
        assert Claim.checked(**fields | {"published": wrong}).verdict == "not reproduced"
        right = fields["computed"] - 0.99 * fields["tolerance"]
        assert Claim.checked(**fields | {"published": right}).verdict == "reproduced"


def verdict_of(claims: Iterable[Claim], id: str) -> str:
    """The verdict of a claim."""
    return next(claim.verdict for claim in claims if claim.id == id)


def with_verdict(claims: Iterable[Claim], verdict: str) -> set[str]:
    """The claims that have a verdict."""
    return {claim.id for claim in claims if claim.verdict == verdict}


def settle_some(study: TableStudy, part: str, numbers: Mapping[str, Any], *names: str) -> dict[str, str]:
    """Verdicts of the claims of a part of some names, from given numbers."""
    blocks = ([row for row in block if row["id"] in names] for block in study.table[part])
    table = {**study.table, part: [block for block in blocks if block]}
    found = settle_claims(table, part, numbers, study.printed)
    return {claim.id: claim.verdict for claim in found}
