"""Base of all kinds of experiment: recognition, scenario proposals, and next records.

A kind is a file of this folder, or an entry point of the group `martensite.experiment_kinds`. The first kind in `order`
that recognises the logs is used.
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


DIAMETER, LENGTH = "element.diameter", "element.length"
_SIZE = r"\s*[=:]?\s*(\d+(?:[.,]\d+)?)\s*(mm|um|µm|cm|m)\b"
SIZES = {
    DIAMETER: (re.compile(rf"(?:\bd|(?i:\bdiameter|\bdurchmesser)|[øØ]){_SIZE}"), ("d", "diameter", "durchmesser")),
    LENGTH: (
        re.compile(rf"(?:\b[Ll]_?0?|(?i:\bgauge length|\bgage length|\bmessl[äa]nge)){_SIZE}"),
        ("l", "l0", "gauge length"),
    ),
}
"""Size of the element -> its pattern in the lines above a table, and the entries that may hold it alone."""


@dataclass(frozen=True)
class Proposal:
    """Scenario that may explain the logs."""

    name: str
    document: Document
    free: tuple[str, ...]
    columns: tuple[str, ...]
    rows: Sequence[Record]
    """Records covered by the proposal, with the required columns."""
    each: tuple[str, ...] = ()
    others: tuple[Mapping[str, float], ...] = ()
    """Further starts: free parameter -> value in SI."""
    spread: int = 0
    """Number of local searches from the best of many points over the bounds."""
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
    """User values by dotted path, which replace assumptions."""
    sentences: list[str] = field(default_factory=list[str])
    header_entries: Mapping[str, Mapping[str, str]] = field(default_factory=dict[str, Mapping[str, str]])
    """Record -> entries in the lines above its table: lower-case word -> text next to it."""
    jitter: dict[str, float] = field(default_factory=dict[str, float])
    """Record -> standard error of its drive after smoothing [SI]."""
    assumed: dict[str, float] = field(default_factory=dict[str, float])
    """Path -> assumed value [SI]."""

    def take(self, path: str, unit: str, value: float, effect: str) -> float:
        """Return the given value [SI] of a path; otherwise use the assumed value, and note its effect."""
        if path in self.settings:
            return self.settle(path, unit, value)
        given = self.find_given(path) if path in SIZES else None
        if given is not None:
            return given
        self.assumed[path] = value
        self.sentences.append(f"`{path}` is assumed to be {write_value(value, unit)}: {effect}.")
        return value

    def settle(self, path: str, unit: str, value: float) -> float:
        """Return the given value [SI] of a path, or a value without effect."""
        return units.parse_quantity(str(self.settings[path]), unit) if path in self.settings else value

    def take_slope(self, name: str, alone: str) -> float:
        """Return the given Clausius–Clapeyron slope [Pa/K]; otherwise the assumed slope, as there is one `alone`."""
        effect = f"with one {alone} only, temperatures at zero stress follow from it"
        return self.take(f"element.law.{name}", "Pa/K", SLOPE, effect)

    def find_said(self, record: Record, words: Sequence[str], pattern: re.Pattern[str]) -> float | None:
        """Return the value of a quantity in the header lines of a record, and note it."""
        for key, text in self.header_entries.get(record.name, {}).items():
            match = pattern.search(text)
            if match is not None and any(word in key for word in words):
                self.sentences.append(f"`{record.name}`: `{text}` in the entry `{key}` of the file.")
                return float(match[1].replace(",", "."))
        return None

    def find_diameter(self) -> float:
        """Return the given diameter of the element [m], or 1 mm."""
        return self.take(DIAMETER, "m", 1e-3, "stresses and moduli are counted from this section")

    def find_given(self, path: str) -> float | None:
        """Return a size of the element [m] from the settings, or from the lines above all tables that have one."""
        if path in self.settings:
            return units.parse_quantity(str(self.settings[path]), "m")
        pattern, keys = SIZES[path]
        sizes: dict[float, str] = {}
        for name, entries in self.header_entries.items():
            for key, text in entries.items():
                match = pattern.search(f"{key}={text}" if key.strip() in keys else text)
                if match is not None:
                    size = units.parse_quantity(f"{match[1].replace(',', '.')} {match[2]}", "m")
                    sizes[size] = f"`{key}` of `{name}`"
        if len(sizes) != 1:
            return None
        ((value, where),) = sizes.items()
        sentence = f"`{path}` is {write_value(value, 'm')} by the entry {where}."
        self.sentences += [] if sentence in self.sentences else [sentence]
        return value


@dataclass(frozen=True)
class FitEvidence:
    """Results of a fit that decide the choice of the next record."""

    experiments: Sequence[Experiment]
    proposal: str
    """Name of the chosen proposal."""
    predicts: bool
    """True if the model predicts held-out data."""
    undetermined: Set[str]
    """Free parameters that the logs do not determine."""


@dataclass(frozen=True)
class RecognisedExperiment:
    """Experiment in a set of logs."""

    kind: AbstractExperimentKind
    why: str
    """Reason in one clause."""
    drive: str = ""
    """Drive column; empty without a drive."""
    measured: tuple[str, ...] = ()
    """Columns to be explained, the most informative first."""

    @property
    def name(self) -> str:
        """Return the registered name of the kind."""
        return self.kind.registered_name


class AbstractExperimentKind:
    """Kind of experiment: recognition, proposed scenarios, and next records."""

    registered_name: ClassVar[str] = ""
    order: ClassVar[float] = 50.0
    """Position in the order of recognition."""
    meaning: ClassVar[str] = ""
    """Description in a few words, such as `a drive makes a force at constant length`."""
    needs: ClassVar[str] = ""
    """Columns that the logs must have, in words."""
    axis: ClassVar[str] = ""
    """Column on the axis of a rate-independent loop; empty if rates matter."""
    own_zero: ClassVar[bool] = False
    """True if each record may have a separate offset or start."""
    shows_shape: ClassVar[bool] = False
    """True if the records show the shape of the transformation, so that rounder laws are tried."""
    given_start: ClassVar[bool] = False
    """True if the initial state of a record is an input, fitted also to a held-out record."""

    command: ClassVar[str] = ""
    """Command of `martensite fit` that evaluates the experiment without a scenario."""

    @abstractmethod
    def recognise(self, survey: LogSurvey) -> RecognisedExperiment | None:
        """Return the experiment in the logs; None for another kind."""

    @abstractmethod
    def propose(
        self, experiment: RecognisedExperiment, records: Sequence[Record], assumptions: Assumptions
    ) -> Iterator[Proposal]:
        """Yield scenarios that may explain the records, the simplest first."""

    @abstractmethod
    def suggest_records(self, evidence: FitEvidence) -> Iterator[str]:
        """Yield sentences on the most informative next records, the most useful first."""

    @abstractmethod
    def make_example(self) -> list[Record]:
        """Return small synthetic records [SI] of such an experiment, for `martensite conform`."""

    def find_time_constant(self, fit: Fit) -> tuple[float, float, float] | None:
        """Return a time constant [s] with its 95 % interval; None if the kind has no time constant."""
        return None


def list_kinds() -> list[AbstractExperimentKind]:
    """Return all kinds of experiment, in the order in which they are tried."""
    return sorted((EXPERIMENT_KINDS[name]() for name in EXPERIMENT_KINDS.names()), key=lambda one: one.order)


def recognise_experiment(records: Sequence[Record], kind_name: str | None = None) -> RecognisedExperiment:
    """Return the experiment in some records.

    Args:
        records: records in SI.
        kind_name: name of the kind, if known.

    Raises:
        UnknownNameError: there is no kind with this name.
        DataError: no kind recognises the records, or the columns of the requested kind are missing.
    """
    kinds = list_kinds() if kind_name is None else [EXPERIMENT_KINDS[kind_name]()]
    survey = LogSurvey(records)
    experiment = next((one for kind in kinds if (one := kind.recognise(survey)) is not None), None)
    if experiment is not None:
        return experiment
    columns = f"they hold {list_names(survey.names)}, of which vary {list_names(survey.varying) or 'none'}"
    if kind_name is not None:
        raise DataError(f"The logs are no `{kind_name}` experiment, which needs {kinds[0].needs}; {columns}.")
    menu = "; ".join(f"`{one.registered_name}`, {one.meaning}" for one in kinds)
    raise DataError(
        f"The experiment in the logs cannot be told: {columns}. Known are {menu}. Name the columns (`--as`), or write "
        "a scenario (--scenario)."
    )


def propose_scenarios(
    experiment: RecognisedExperiment,
    records: Sequence[Record],
    settings: Mapping[str, Any],
    header_entries: Mapping[str, Mapping[str, str]] | None = None,
) -> tuple[list[Proposal], Assumptions]:
    """Return the scenarios that may explain the records of an experiment, and their assumptions.

    Args:
        experiment: recognised experiment.
        records: records in SI.
        settings: values by dotted path, which replace assumptions.
        header_entries: entries in the lines above the tables, by record.

    Raises:
        DataError: required data are missing; the message asks for them.
    """
    assumptions = Assumptions(settings, header_entries=header_entries or {})
    proposals = [
        replace(one, jitter=assumptions.jitter) for one in experiment.kind.propose(experiment, records, assumptions)
    ]
    if settings:
        proposals = [replace(one, document=change_document(one.document, settings)) for one in proposals]
    return proposals, assumptions
