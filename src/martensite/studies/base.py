"""Base of all studies: a digest, claims with verdicts, reports, and a figure.

A study is a folder of this package, or an entry point of the group `martensite.studies`. A study that cannot be
imported or loaded fails alone.

A claim compares a printed number with a computed number, and has one of six verdicts:

    reproduced            |computed - published| ≤ tolerance
    disagrees             the difference is larger, without a reason in print
    misprint              the difference is larger because of an error in print; `correction` names it
    self-contradictory    the difference is larger, and both numbers follow from the source; `against` names the other
    not comparable        the source has another wire or record, or omits data; `differs` names the difference
    recovery              the number was chosen or fitted with published numbers: agreement proves nothing

The first four need a tolerance with a reason, at most a fifth of the published number. A verdict that contradicts its
numbers is refused. A report is a computed number without a printed counterpart.
"""

from __future__ import annotations

import sys
import tomllib
from abc import abstractmethod
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, Literal, get_args

from martensite.base.errors import ParameterError, StoppedError
from martensite.base.interfaces import make_missing_error
from martensite.base.module_folder import describe_error
from martensite.base.registry import Registry

Verdict = Literal["reproduced", "disagrees", "misprint", "self-contradictory", "not comparable", "recovery"]
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)
GROUNDS = {"misprint": "correction", "self-contradictory": "against", "not comparable": "differs"}
"""Field that a claim of each verdict must have; other verdicts must not have it."""
WIDEST = 0.2
"""Largest tolerance, as a fraction of the published number."""
DIGEST = ("holds", "misprinted", "contradicts_itself", "assumed", "use_instead")
"""Keys of a digest."""
STUDIES: Registry[AbstractStudy] = Registry("study", "martensite.studies")


def judge_number(published: float, computed: float, tolerance: float) -> Verdict:
    """Return the verdict of a number by its distance; a non-finite number disagrees."""
    return "reproduced" if abs(computed - published) <= tolerance else "disagrees"


@dataclass(frozen=True)
class Claim:
    """One statement of a source, with its printed and its computed number."""

    id: str
    statement: str
    source: str
    """Bibliography key, and section, table or equation."""
    published: float | None
    """Published value; None if only an equation is printed."""
    computed: float | None
    unit: str
    tolerance: float | None
    """Largest allowed difference, in `unit`."""
    verdict: Verdict
    why: str
    """Basis of the verdict, or reason for the difference."""
    tolerance_reason: str = ""
    as_printed: float | None = None
    """Result of a misprinted equation as printed."""
    correction: str = ""
    against: str = ""
    """For a contradiction, the other printed statement and its place."""
    differs: str = ""
    """For incomparable numbers, the difference or the omitted data."""

    def __post_init__(self) -> None:
        """Raise `ParameterError` if the verdict contradicts numbers or grounds."""
        where = f"Claim `{self.id}` is {self.verdict} and"
        for verdict, name in GROUNDS.items():
            if (verdict == self.verdict) != bool(getattr(self, name)):
                raise ParameterError(f"{where} must have {'a' if verdict == self.verdict else 'no'} `{name}`.")
        if self.verdict in ("not comparable", "recovery"):
            if self.tolerance is not None:
                raise ParameterError(f"{where} must have no tolerance, but has {self.tolerance:g}.")
            return
        printed = self.as_printed if self.published is None and self.correction else self.published
        if printed is None or self.computed is None or self.tolerance is None or not self.tolerance_reason:
            raise ParameterError(f"{where} must have a published number, a computed one, a tolerance and its reason.")
        if not 0.0 <= self.tolerance <= WIDEST * abs(printed):
            most = WIDEST * abs(printed)
            raise ParameterError(f"{where} must have a tolerance up to {most:g}, but has {self.tolerance:g}.")
        right = judge_number(printed, self.computed, self.tolerance)
        if (right == "reproduced") != (self.verdict == "reproduced"):
            raise ParameterError(f"Claim `{self.id}` {right} by its numbers and cannot be {self.verdict}.")

    def describe_reason(self) -> str:
        """Return place, ground and reason of the verdict in one line."""
        grounds = [f"{name}: {getattr(self, name)}" for name in GROUNDS.values() if getattr(self, name)]
        margin = [] if self.tolerance is None else [f"tolerance {self.tolerance:.3g}: {self.tolerance_reason}"]
        return "; ".join([self.source, *grounds, self.why, *margin]) + "."


@dataclass(frozen=True)
class StudyReport:
    """A computed number without a printed counterpart."""

    id: str
    statement: str
    source: str
    """Bibliography key, and the related place."""
    computed: float | None
    unit: str
    why: str


@dataclass(frozen=True)
class Answer:
    """Claims, reports and digest of a study, or of a part."""

    claims: Sequence[Claim]
    reports: Sequence[StudyReport] = ()
    digest: Mapping[str, str] = field(default_factory=dict[str, str])
    """Sentences by the keys of `DIGEST`."""
    made_by: str = ""
    """Program of shipped numbers; empty if computed now."""

    @classmethod
    def join(cls, parts: Sequence[Answer], digest: Mapping[str, str], made_by: str = "") -> Answer:
        """Return the claims and reports of all parts, with a digest."""
        claims, reports = ([one for part in parts for one in getattr(part, kind)] for kind in ("claims", "reports"))
        return cls(claims, reports, digest, made_by)

    def count_all(self) -> dict[str, int]:
        """Return the number of claims of each verdict, and the number of reports."""
        counted = Counter(claim.verdict for claim in self.claims)
        return {verdict: counted[verdict] for verdict in VERDICTS} | {"reports": len(self.reports)}


class AbstractStudy:
    """Interface of a study; one class per folder, registered with `@STUDIES.register(key)`."""

    registered_name: ClassVar[str] = ""
    title: ClassVar[str] = ""
    order: ClassVar[int] = sys.maxsize
    """Position in lists."""
    cites: ClassVar[tuple[str, ...]] = ()
    """Bibliography keys of the paper and other sources."""
    guide: ClassVar[str] = ""
    """Work of the paper, rebuilt parts and highlights; paragraphs separated by blank lines."""
    caption: ClassVar[str] = ""
    """Caption of the figure, in one sentence."""
    scenario_files: ClassVar[tuple[str, ...]] = ()
    """Scenarios that run alone: file names in its folder, or full paths."""
    data: ClassVar[tuple[str, ...]] = ()
    """Data sets outside the package, needed by some claims."""
    full: bool = False
    """True if slow parts are computed."""

    @property
    def key(self) -> str:
        """Return the name of the study."""
        return self.registered_name

    def parts(self) -> dict[str, Callable[[], Answer]]:
        """Return the functions that compute claims and reports, by description of the part."""
        if type(self).claims is AbstractStudy.claims:
            raise make_missing_error(type(self), ["claims"])
        return {"all claims": lambda: Answer(self.claims())}

    def claims(self) -> list[Claim]:
        """Return all claims, computed now."""
        return [claim for part in self.parts().values() for claim in part().claims]

    def digest(self) -> Mapping[str, str]:
        """Return a summary by the keys of `DIGEST`, computed now."""
        return {}

    def compute(self) -> Answer:
        """Return digest, claims and reports, computed now."""
        return Answer.join([part() for part in self.parts().values()], self.digest())

    def load_shipped_answer(self) -> Answer | None:
        """Return the answer from shipped numbers, or None."""
        return None

    def shipped_figure(self) -> Path | None:
        """Return the path of the shipped figure, or None."""
        return None

    def find_answer(self, recompute: bool = False) -> Answer:
        """Return the shipped answer; without one or on demand, compute the full answer."""
        if not recompute and (shipped := self.load_shipped_answer()):
            return shipped
        self.full = True
        return self.compute()

    def scenarios(self) -> dict[str, str]:
        """Return title and text of each of its `scenario_files`."""
        folder = Path(str(sys.modules[type(self).__module__].__file__)).parent
        texts = [(folder / name).read_text("utf-8") for name in self.scenario_files]
        return {str(tomllib.loads(text)["title"]): text for text in texts}

    @abstractmethod
    def figure(self, path: Path) -> None:
        """Write the figure (png, svg or pdf)."""


def load_studies() -> tuple[list[AbstractStudy], list[str]]:
    """Load all installed studies.

    Returns:
        The studies in their order, and a sentence for each study that cannot be loaded.
    """
    loaded: list[AbstractStudy] = []
    failed: list[str] = []
    for name in STUDIES.names():
        try:
            loaded.append(STUDIES[name]())
        except Exception as error:  # a half-written study may raise anything
            failed.append(describe_failure(name, error))
    return sorted(loaded, key=lambda one: one.order), [*STUDIES.failures(), *failed]


def study_names() -> list[str]:
    """Return the names of all studies that can be loaded."""
    return [one.key for one in load_studies()[0]]


def describe_failure(name: str, error: Exception) -> str:
    """Return a sentence on the error of one study; an interruption is raised again."""
    if isinstance(error, StoppedError):
        raise error
    return f"The study `{name}` failed: {describe_error(error)}."


def load_study(name: str) -> AbstractStudy:
    """Return a study by its name.

    Raises:
        UnknownNameError: the study does not exist.
        InputError: its files cannot be imported.
    """
    return STUDIES[name]()
