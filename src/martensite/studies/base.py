"""Base of all studies: a digest, claims with verdicts, reports, and a figure.

A study is a folder of this package, or an entry point of the group `martensite.studies`. A study that cannot be
imported or loaded fails alone.

A claim compares a number that a source prints with a computed number. It has one of six verdicts:

    reproduced            |computed - published| ≤ tolerance
    disagrees             it is larger, for no reason in print
    misprint              it is larger because of an error in print: the correction is named
    self-contradictory    it is larger, and both numbers follow from printed statements: both are named
    not comparable        the source has another wire or record, or omits needed data: the difference is named
    recovery              the number was chosen or fitted with published numbers: agreement proves nothing

The first four rest on a tolerance, which has a reason and is at most a fifth of the published number. A claim whose
verdict contradicts its numbers cannot be made. A computed number without a printed counterpart is a report.
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
"""Field that a claim of each verdict must have, and that is forbidden for other verdicts."""
WIDEST = 0.2
"""Largest tolerance, as a share of the published number."""
DIGEST = ("holds", "misprinted", "contradicts_itself", "assumed", "use_instead")
"""Keys of a digest."""
STUDIES: Registry[AbstractStudy] = Registry("study", "martensite.studies")


def judge_number(published: float, computed: float, tolerance: float) -> Verdict:
    """The verdict on a number by its distance alone; one that is not finite never agrees."""
    return "reproduced" if abs(computed - published) <= tolerance else "disagrees"


@dataclass(frozen=True)
class Claim:
    """One statement of a source, with the number that it prints and the one computed here."""

    id: str
    statement: str
    source: str
    """Key of the source in the bibliography, and the section, table or equation there."""
    published: float | None
    """Published value as printed; None where only an equation is printed."""
    computed: float | None
    unit: str
    tolerance: float | None
    """Largest difference that counts as agreement, in `unit`."""
    verdict: Verdict
    why: str
    """Basis of the verdict, or reason for the difference."""
    tolerance_reason: str = ""
    as_printed: float | None = None
    """Result of a misprinted equation as printed."""
    correction: str = ""
    """Correction of a misprint."""
    against: str = ""
    """For a contradiction, the other printed statement and its place, from which the computed number follows."""
    differs: str = ""
    """For incomparable numbers, the difference or the omitted data."""

    def __post_init__(self) -> None:
        """Raise `ParameterError` if the verdict is not the one that the numbers and grounds have."""
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
        """Place, ground and reason of the verdict in a line."""
        grounds = [f"{name}: {getattr(self, name)}" for name in GROUNDS.values() if getattr(self, name)]
        margin = [] if self.tolerance is None else [f"tolerance {self.tolerance:.3g}: {self.tolerance_reason}"]
        return "; ".join([self.source, *grounds, self.why, *margin]) + "."


@dataclass(frozen=True)
class StudyReport:
    """A number computed here for which the source prints none."""

    id: str
    statement: str
    source: str
    """Key of the source, and the place that the number is about."""
    computed: float | None
    unit: str
    why: str


@dataclass(frozen=True)
class Answer:
    """All that a study, or a part of one, has found."""

    claims: Sequence[Claim]
    reports: Sequence[StudyReport] = ()
    digest: Mapping[str, str] = field(default_factory=dict[str, str])
    """Sentences by the keys of `DIGEST`."""
    made_by: str = ""
    """Program that computed the numbers, if they were not computed now."""

    @classmethod
    def join(cls, parts: Sequence[Answer], digest: Mapping[str, str], made_by: str = "") -> Answer:
        """The claims and reports of all parts, with a digest."""
        claims, reports = ([one for part in parts for one in getattr(part, kind)] for kind in ("claims", "reports"))
        return cls(claims, reports, digest, made_by)

    def count_all(self) -> dict[str, int]:
        """Return the number of claims of each verdict, and the number of reports."""
        counted = Counter(claim.verdict for claim in self.claims)
        return {verdict: counted[verdict] for verdict in VERDICTS} | {"reports": len(self.reports)}


class AbstractStudy:
    """Interface of a study; one class per folder, filed with `@STUDIES.register(key)`."""

    registered_name: ClassVar[str] = ""
    title: ClassVar[str] = ""
    order: ClassVar[int] = sys.maxsize
    """Position in a list; studies of one source are adjacent."""
    cites: ClassVar[tuple[str, ...]] = ()
    """Bibliography keys of the paper and of everything that the rebuild rests on."""
    guide: ClassVar[str] = ""
    """Work of the paper, rebuilt parts and highlights: paragraphs with a blank line between them."""
    caption: ClassVar[str] = ""
    """Caption of the figure, in one sentence."""
    scenario_files: ClassVar[tuple[str, ...]] = ()
    """Scenarios of the study that run by themselves: files in its folder, or by their full path."""
    data: ClassVar[tuple[str, ...]] = ()
    """Data sets that are not part of the package, without which some claims have no number."""
    full: bool = False
    """True if what takes long is computed too."""

    @property
    def key(self) -> str:
        """Name of the study."""
        return self.registered_name

    def parts(self) -> dict[str, Callable[[], Answer]]:
        """Return the functions that compute claims and reports, by a description of the part."""
        if type(self).claims is AbstractStudy.claims:
            raise make_missing_error(type(self), ["claims"])
        return {"all claims": lambda: Answer(self.claims())}

    def claims(self) -> list[Claim]:
        """Every claim with its verdict, computed now."""
        return [claim for part in self.parts().values() for claim in part().claims]

    def digest(self) -> Mapping[str, str]:
        """Return a summary of a few lines by the keys of `DIGEST`, from numbers computed now."""
        return {}

    def compute(self) -> Answer:
        """Digest, claims and reports, computed now."""
        return Answer.join([part() for part in self.parts().values()], self.digest())

    def shipped(self) -> Answer | None:
        """Return the answer from numbers that came with the package; None without shipped numbers."""
        return None

    def find_answer(self, recompute: bool = False) -> Answer:
        """Return the shipped answer; without it or on demand, compute the full answer."""
        if not recompute and (shipped := self.shipped()):
            return shipped
        self.full = True
        return self.compute()

    def scenarios(self) -> dict[str, str]:
        """Title and text of each of its `scenario_files`."""
        folder = Path(str(sys.modules[type(self).__module__].__file__)).parent
        texts = [(folder / name).read_text("utf-8") for name in self.scenario_files]
        return {str(tomllib.loads(text)["title"]): text for text in texts}

    @abstractmethod
    def figure(self, path: Path) -> None:
        """Write the figure that a reader of the paper recognises (png, svg or pdf)."""


def load_studies() -> tuple[list[AbstractStudy], list[str]]:
    """Load all studies that are installed.

    Returns:
        The studies, those of one source together, and a sentence for each study that cannot be loaded.
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
    """Return the names of all studies that can be loaded, those of one source together."""
    return [one.key for one in load_studies()[0]]


def describe_failure(name: str, error: Exception) -> str:
    """Return a sentence on the error of one study.

    Raises:
        StoppedError: the error is an interruption, which stops the command.
    """
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
