"""Base of all kinds of experiment: when logs hold one, which scenarios may explain it, and what to record next.

A kind is one file of this folder, or an entry point of the group `martensite.experiment_kinds`. The kinds are asked in
their `order`; the first that recognises the logs is taken.
"""

from __future__ import annotations

import re
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

from martensite.base import units
from martensite.base.errors import DataError
from martensite.base.registry import Registry
from martensite.base.toml_text import as_toml
from martensite.fit.experiment_kinds.survey import LogSurvey
from martensite.fit.experiment_kinds.values import SLOPE, Document, write_value
from martensite.scenario.overrides import change_document
from martensite.search.quantity_text import list_names
from martensite.signals.records import Record

if TYPE_CHECKING:
    from martensite.fit.experiment import Experiment
    from martensite.fit.fit import Fit

EXPERIMENT_KINDS: Registry[AbstractExperimentKind] = Registry("experiment", "martensite.fit.experiment_kinds")


@dataclass(frozen=True)
class Proposal:
    """One scenario that may explain the logs."""

    name: str
    document: Document
    free: tuple[str, ...]
    columns: tuple[str, ...]
    rows: Sequence[Record]
    """The records that it explains, with the columns that it needs."""
    each: tuple[str, ...] = ()
    others: tuple[Mapping[str, float], ...] = ()
    """Further starts: free parameter -> value in SI."""
    spread: int = 0
    """Local searches that begin at the best of many points over the bounds."""
    jitter: Mapping[str, float] = field(default_factory=dict[str, float])
    """Record -> standard error of its drive after smoothing [SI]."""

    @property
    def text(self) -> str:
        """Return the scenario as TOML."""
        return as_toml(self.document)


@dataclass
class Assumptions:
    """Assumptions beyond the logs: values, and sentences about them."""

    settings: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Values by dotted path that the user gives instead."""
    sentences: list[str] = field(default_factory=list[str])
    said: Mapping[str, Mapping[str, str]] = field(default_factory=dict[str, Mapping[str, str]])
    """Record -> entries in the lines above its table: lower-case word -> text next to it."""
    jitter: dict[str, float] = field(default_factory=dict[str, float])
    """Record -> standard error of its drive after smoothing [SI]."""
    assumed: dict[str, float] = field(default_factory=dict[str, float])
    """Path -> assumed value [SI]."""

    def take(self, path: str, unit: str, value: float, effect: str) -> float:
        """Return the given value [SI] of a path; otherwise the assumed one, and note it with its effect."""
        if path in self.settings:
            return self.settle(path, unit, value)
        self.assumed[path] = value
        self.sentences.append(f"`{path}` is assumed to be {write_value(value, unit)}: {effect}.")
        return value

    def settle(self, path: str, unit: str, value: float) -> float:
        """Return the given value [SI] of a path, or one that changes nothing."""
        return units.parse_quantity(str(self.settings[path]), unit) if path in self.settings else value

    def take_slope(self, name: str, alone: str) -> float:
        """Return the given Clausius–Clapeyron slope [Pa/K]; otherwise the assumed one, since there is one `alone`."""
        effect = f"with one {alone} only, temperatures at zero stress follow from it"
        return self.take(f"element.law.{name}", "Pa/K", SLOPE, effect)

    def find_said(self, record: Record, words: Sequence[str], pattern: re.Pattern[str]) -> float | None:
        """Return the number that the file of a record gives for a quantity above its table, and note the words."""
        for key, text in self.said.get(record.name, {}).items():
            found = pattern.search(text)
            if found is not None and any(word in key for word in words):
                self.sentences.append(f"`{record.name}`: its file says `{key}`: `{text}`.")
                return float(found[1].replace(",", "."))
        return None

    def find_diameter(self, matters: bool) -> float:
        """Return the diameter of the element [m]: the given one, or 1 mm."""
        if not matters and "element.diameter" not in self.settings:
            return 1e-3
        return self.take("element.diameter", "m", 1e-3, "stresses and moduli are counted from this section")


@dataclass(frozen=True)
class FitEvidence:
    """Results of a fit that decide which record is worth recording next."""

    experiments: Sequence[Experiment]
    proposal: str
    """Name of the chosen proposal."""
    predicts: bool
    """True if the model predicts held-out data."""
    undetermined: Set[str]
    """Free parameters that the logs do not determine, alone or together."""


@dataclass(frozen=True)
class RecognisedExperiment:
    """Experiment in a set of logs."""

    kind: AbstractExperimentKind
    why: str
    """Reason in one clause."""
    drive: str = ""
    """Column that drives; empty for none."""
    measured: tuple[str, ...] = ()
    """Columns to be explained, the most telling first."""

    @property
    def name(self) -> str:
        """Return the registered name of the kind."""
        return self.kind.registered_name


class AbstractExperimentKind:
    """Kind of experiment: rule of recognition, proposed scenarios, and next records."""

    registered_name: ClassVar[str] = ""
    order: ClassVar[float] = 50.0
    """Place in the order in which kinds are tried."""
    meaning: ClassVar[str] = ""
    """Description in a few words, such as `a drive makes a force at constant length`."""
    needs: ClassVar[str] = ""
    """Columns that the logs must have, in words."""
    axis: ClassVar[str] = ""
    """Column over which a loop without rates is drawn; empty if rates matter."""
    own_zero: ClassVar[bool] = False
    """True if each record may have its own zero or start."""
    shows_shape: ClassVar[bool] = False
    """True if the records show the shape of the transformation, so that rounder laws are tried."""
    given_start: ClassVar[bool] = False
    """True if the state in which a record begins is part of the input, so that it is fitted to a held-out record."""

    @abstractmethod
    def recognise(self, survey: LogSurvey) -> RecognisedExperiment | None:
        """Return the experiment that the logs hold; None if it is of another kind."""

    @abstractmethod
    def propose(self, found: RecognisedExperiment, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
        """Yield scenarios that may explain the records, the simplest first."""

    @abstractmethod
    def suggest_records(self, evidence: FitEvidence) -> Iterator[str]:
        """Yield sentences on records that would tell more, the most useful first."""

    @abstractmethod
    def make_example(self) -> list[Record]:
        """Return small made records [SI] of such an experiment; `martensite conform` tries the kind with them."""

    def find_time_constant(self, fit: Fit) -> tuple[float, float, float] | None:
        """Return a time constant [s] with its 95 % interval; None if the kind has none."""
        return None


def list_kinds() -> list[AbstractExperimentKind]:
    """Return all kinds of experiment, in the order in which they are tried."""
    return sorted((EXPERIMENT_KINDS[name]() for name in EXPERIMENT_KINDS.names()), key=lambda one: one.order)


def recognise_experiment(records: Sequence[Record], asked: str | None = None) -> RecognisedExperiment:
    """Return the experiment that some records hold.

    Args:
        records: in SI.
        asked: name of the kind, if it is known.

    Raises:
        UnknownNameError: no kind has the name.
        DataError: no kind recognises the records, or the columns of the requested kind are missing.
    """
    kinds = list_kinds() if asked is None else [EXPERIMENT_KINDS[asked]()]
    survey = LogSurvey(records)
    found = next((one for kind in kinds if (one := kind.recognise(survey)) is not None), None)
    if found is not None:
        return found
    columns = f"they hold {list_names(survey.names)}, of which vary {list_names(survey.varying) or 'none'}"
    if asked is not None:
        raise DataError(f"The logs are no `{asked}` experiment, which needs {kinds[0].needs}; {columns}.")
    known = "; ".join(f"`{one.registered_name}`, {one.meaning}" for one in kinds)
    raise DataError(
        f"The experiment in the logs cannot be told: {columns}. Known are {known}. Name the columns (`--as`), or write "
        "a scenario (--scenario)."
    )


def propose_scenarios(
    found: RecognisedExperiment,
    records: Sequence[Record],
    settings: Mapping[str, Any],
    said: Mapping[str, Mapping[str, str]] | None = None,
) -> tuple[list[Proposal], Assumptions]:
    """Return the scenarios that may explain the records of an experiment, and what they assume.

    Args:
        found: the experiment.
        records: in SI.
        settings: values by dotted path, which replace assumptions.
        said: entries in the lines above the tables, by record.

    Raises:
        DataError: indispensable data are missing; one sentence asks for them.
    """
    known = Assumptions(settings, said=said or {})
    proposals = [replace(one, jitter=known.jitter) for one in found.kind.propose(found, records, known)]
    if settings:
        proposals = [replace(one, document=change_document(one.document, settings)) for one in proposals]
    return proposals, known
