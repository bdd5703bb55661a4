"""Kinds of uploaded logs, in one sentence each, and proposed scenarios."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from martensite.actuators.assembly import AbstractSystem
from martensite.app.messages import JsonTable
from martensite.app.views.columns import describe_conversion, describe_difference
from martensite.base import units
from martensite.base.errors import DataError, MartensiteError
from martensite.base.formats import typeset_unit
from martensite.fit.experiment_kinds.base import Proposal, RecognisedExperiment, propose_scenarios, recognise_experiment
from martensite.fit.free_parameters import build_free_numbers, is_difference, read_ranges
from martensite.logs.lab_files import LabFile
from martensite.logs.raw_table import LeftOut
from martensite.scenario.scenario import read_scenario
from martensite.search.free_numbers import SearchRange
from martensite.search.quantity_text import join_phrases
from martensite.signals.records import Record


def find_experiment(records: Sequence[Record]) -> RecognisedExperiment | None:
    """Return the experiment of records, or None if unknown."""
    try:
        return recognise_experiment(records)
    except MartensiteError:
        return None


def describe_reading(file: LabFile, timed: bool) -> str:
    """Describe the format of a file, its columns, and omitted rows in one or two sentences."""
    guess = find_experiment([file.record])
    warm = [one.name for one in file.columns if one.si and one.name != "time"] == ["temperature"]
    alone = "The file has only a temperature: add the log of its drive, and merge the two." if warm else ""
    experiment = alone if alone and not guess else _describe_experiment(guess)
    return f"{_describe_columns(file)}. {experiment}{_describe_times(guess, timed)}"


def _describe_columns(file: LabFile) -> str:
    used = [one for one in file.columns if one.si]
    units = {one.name: typeset_unit(one.unit, "plain numbers") for one in used}
    entries = [f"`{name}` {'by the' if unit == 'clock' else 'in'} {unit}" for name, unit in units.items()]
    sentence = f"{file.format[:1].upper()}{file.format[1:]}: {join_phrases(entries)}"
    sentence += ", recognised by their values" if any(one.source == "values" for one in used) else ""
    unused = len(file.columns) - len(used)
    sentence += f"; {unused} more column{'s are' if unused > 1 else ' is'} not used" if unused else ""
    lost = [_describe_lost(one) for one in file.dropped]
    return sentence + (f"; left out: {join_phrases(lost)}" if lost else "")


def _describe_lost(one: LeftOut) -> str:
    rows = ", ".join(map(str, one.rows)) + (", …" if one.count > len(one.rows) else "")
    return f"{one.count} row{'s' if one.count > 1 else ''} ({one.reason}: {rows})"


def _describe_experiment(experiment: RecognisedExperiment | None) -> str:
    return (
        f"Taken as {experiment.name}: {experiment.kind.meaning}."
        if experiment
        else "No known experiment is recognised."
    )


def _describe_times(experiment: RecognisedExperiment | None, timed: bool) -> str:
    if timed:
        return ""
    if experiment is not None and experiment.kind.axis:
        return " It has no times, and needs none: a slow loop follows its turning points only."
    return " It has no times: its rows count as 1 s apart, unless you say otherwise."


@dataclass(frozen=True)
class ProposedModels:
    """Proposed models of records."""

    experiment: RecognisedExperiment
    proposals: Sequence[Proposal]
    notes: Sequence[str]

    def find(self, name: str) -> Proposal:
        """Return a proposal by name."""
        table = {one.name: one for one in self.proposals}
        if name not in table:
            raise DataError(f"Nothing is proposed as `{name}` for these records; known are {', '.join(table)}.")
        return table[name]


def propose_models(records: Sequence[Record], settings: Mapping[str, str]) -> ProposedModels:
    """Return the proposed scenarios of records, in the order of the library."""
    experiment = recognise_experiment(records)
    proposals, assumptions = propose_scenarios(experiment, records, settings)
    return ProposedModels(experiment, proposals, tuple(dict.fromkeys(assumptions.sentences)))


def describe_proposal(one: Proposal) -> JsonTable:
    """Return a proposal for the page: its scenario and free parameters in SI."""
    system = read_scenario(one.text, log=one.rows[0]).system
    return {
        "name": one.name,
        "text": one.text,
        "free": [_describe_range(search_range, system) for search_range in read_ranges(one.free, [system])],
        "each": [search_range.name for search_range in read_ranges(one.each, [system], own=True)],
        "starts": one.spread,
    }


def _describe_range(search_range: SearchRange, system: AbstractSystem) -> JsonTable:
    (free,) = build_free_numbers([search_range], [system])
    spelling = units.choose_familiar_unit(free.start, free.unit)
    how = describe_difference(search_range.name, free.unit) if is_difference(search_range.name) else None
    return {
        "name": search_range.name,
        "low": search_range.low,
        "high": search_range.high,
        "start": search_range.start,
        "scale": search_range.scale,
        "usual": [free.start, free.low, free.high],
        "doc": free.doc,
        **(how or describe_conversion(free.unit, spelling)),
    }
