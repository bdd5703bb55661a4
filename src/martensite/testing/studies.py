"""Suite of studies: words, sources, claims and digest of the shipped or computed answer."""

from collections import Counter

from martensite.scenario.citations import read_bibliography
from martensite.studies.base import DIGEST, AbstractStudy
from martensite.testing.conformance import require_condition


def check_words(study: AbstractStudy) -> None:
    """It has a title, a guide and a caption of its figure."""
    for name in ("title", "guide", "caption"):
        require_condition(getattr(study, name).strip(), f"`{name}` is empty")


def check_sources(study: AbstractStudy) -> None:
    """Every source is in the bibliography."""
    unknown = sorted({*study.cites} - {*read_bibliography()})
    require_condition(not unknown, f"the bibliography has no `{', '.join(unknown)}`")


def check_claims(study: AbstractStudy) -> None:
    """It has claims, each with a unique name."""
    answer = study.find_answer()
    counts = Counter(one.id for one in (*answer.claims, *answer.reports))
    double = [id for id, count in counts.items() if count > 1]
    require_condition(answer.claims, "it has no claim")
    require_condition(not double, f"two claims or reports have the name `{', '.join(double)}`")


def check_digest(study: AbstractStudy) -> None:
    """Its digest has only known keys."""
    unknown = sorted({*study.find_answer().digest} - {*DIGEST})
    require_condition(not unknown, f"`{', '.join(unknown)}` is no key of a digest; use {', '.join(DIGEST)}")
