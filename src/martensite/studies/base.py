"""What every study answers: claims with verdicts, and a figure.

Studies register by entry points of the group `martensite.studies`. Those of published works are a
distribution of their own, `martensite-studies`, which the extra `martensite[studies]` brings.

A claim sets a published number beside a computed one. Its verdict follows from

    |computed - published| ≤ tolerance    reproduced, otherwise not reproduced

and from nothing else: a claim whose verdict contradicts its numbers cannot be made. Two more verdicts stand outside
that rule. `calibrated` marks a number that was itself chosen to meet the published one, so that agreement says nothing;
`not checkable` one for which the source prints no number.
"""

from __future__ import annotations

import sys
import tomllib
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, ClassVar, Literal

from martensite.base.errors import InputError, ParameterError, UnknownNameError
from martensite.base.interfaces import make_missing_error
from martensite.base.registry import Registry

Verdict = Literal["reproduced", "not reproduced", "calibrated", "not checkable"]
STUDIES: Registry[AbstractStudy] = Registry("study", "martensite.studies")
INSTALLATION = "`pip install 'martensite[studies]'` brings those of published works"


def judge_number(published: float, computed: float, tolerance: float) -> Verdict:
    """The verdict on a number that can be checked; one that is not finite never agrees."""
    return "reproduced" if abs(computed - published) <= tolerance else "not reproduced"


@dataclass(frozen=True)
class Claim:
    """One statement of a source, with the number it prints and the one computed here."""

    id: str
    statement: str
    source: str
    """Key of the source in the bibliography, and the section, table or equation there."""
    published: float | None
    computed: float | None
    unit: str
    tolerance: float | None
    """Largest difference that counts as agreement, in `unit`."""
    verdict: Verdict
    why: str
    """What the verdict rests on, or why the numbers differ."""

    def __post_init__(self) -> None:
        """Raise `ParameterError` if the verdict is not the one the numbers have."""
        numbers = (self.published, self.computed, self.tolerance)
        if self.verdict in ("calibrated", "not checkable"):
            if self.tolerance is not None:
                raise ParameterError(
                    f"Claim `{self.id}` is {self.verdict} and must have no tolerance, but has {self.tolerance:g}."
                )
        elif self.published is None or self.computed is None or self.tolerance is None:
            raise ParameterError(
                f"Claim `{self.id}` is {self.verdict} and must have a published number, a "
                f"computed one and a tolerance, but has {numbers}."
            )
        elif (right := judge_number(self.published, self.computed, self.tolerance)) != self.verdict:
            raise ParameterError(f"Claim `{self.id}` must be {right} by its numbers, but is {self.verdict}.")

    @classmethod
    def checked(
        cls,
        id: str,
        statement: str,
        source: str,
        published: float,
        computed: float,
        unit: str,
        tolerance: float,
        why: str,
    ) -> Claim:
        """A claim whose verdict follows from its numbers."""
        if not tolerance >= 0.0:
            raise ParameterError(f"Tolerance of claim `{id}` must be at least 0, but is {tolerance:g}.")
        verdict = judge_number(published, computed, tolerance)
        return cls(id, statement, source, published, computed, unit, tolerance, verdict, why)

    @classmethod
    def calibrated(
        cls, id: str, statement: str, source: str, published: float | None, computed: float, unit: str, why: str
    ) -> Claim:
        """A number chosen so that the published one comes out."""
        return cls(id, statement, source, published, computed, unit, None, "calibrated", why)

    @classmethod
    def reported(cls, id: str, statement: str, source: str, computed: float, unit: str, why: str) -> Claim:
        """A computed number for which the source prints none."""
        return cls(id, statement, source, None, computed, unit, None, "not checkable", why)

    def to_dict(self) -> dict[str, Any]:
        """All fields by name, for JSON."""
        return asdict(self)


class AbstractStudy:
    """Interface of a study; one class per folder, filed with `@STUDIES.register(key)`."""

    registered_name: ClassVar[str] = ""
    title: ClassVar[str] = ""
    cites: ClassVar[tuple[str, ...]] = ()
    """Bibliography keys of the paper and of everything that the rebuild rests on."""
    guide: ClassVar[str] = ""
    """What the paper did, what is rebuilt, what to look at: paragraphs with a blank line between them."""
    caption: ClassVar[str] = ""
    """What its figure shows, in a sentence."""
    scenario_files: ClassVar[tuple[str, ...]] = ()
    """Scenarios of the study that run by themselves: files in its folder, or by their full path."""
    data: ClassVar[tuple[str, ...]] = ()
    """Data sets that are not part of the package, without which some claims have no number."""

    @property
    def key(self) -> str:
        """Name of the study."""
        return self.registered_name

    def parts(self) -> dict[str, Callable[[], list[Claim]]]:
        """What computes the claims, part by part, each with words for what it is about."""
        if type(self).claims is AbstractStudy.claims:
            raise make_missing_error(type(self), ["claims"])
        return {"all claims": self.claims}

    def claims(self) -> list[Claim]:
        """Every claim with its verdict, computed now."""
        return [claim for part in self.parts().values() for claim in part()]

    def scenarios(self) -> dict[str, str]:
        """Title and text of each of its `scenario_files`."""
        folder = Path(str(sys.modules[type(self).__module__].__file__)).parent
        texts = [(folder / name).read_text("utf-8") for name in self.scenario_files]
        return {str(tomllib.loads(text)["title"]): text for text in texts}

    @abstractmethod
    def figure(self, path: Path) -> None:
        """Write the figure that a reader of the paper recognises (png, svg or pdf)."""

    def to_dict(self) -> dict[str, Any]:
        """Key, title, citations and claims, for JSON."""
        claims = [claim.to_dict() for claim in self.claims()]
        return {"key": self.key, "title": self.title, "cites": list(self.cites), "claims": claims}


def study_names() -> list[str]:
    """Names of all studies that are installed.

    Raises:
        InputError: there is none.
    """
    names = STUDIES.names()
    if not names:
        raise InputError(f"No study is installed; {INSTALLATION}.")
    return names


def load_study(name: str) -> AbstractStudy:
    """A study by its name.

    Raises:
        InputError: the studies of published works are not installed.
        UnknownNameError: they are, and there is none of that name.
    """
    try:
        return STUDIES[name]()
    except UnknownNameError:
        if find_spec("martensite_studies") is not None:
            raise
        raise InputError(f"No study `{name}` is installed; {INSTALLATION}.") from None
