"""Sections around a part of another kind: ports, signals, levels, references, cooling.

Successive candidates keep less of them; the first that can be built is used.
"""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from typing import Any

from martensite.app.forms import documents
from martensite.app.forms.control_tree import place_units
from martensite.app.forms.table_filler import KIND, ChangedScenario, TableFiller
from martensite.app.messages import JsonTable
from martensite.base.files import toml_document
from martensite.base.parameters import Parametrised
from martensite.physics.electrical.base import SOURCES
from martensite.physics.thermal.base import COOLING
from martensite.scenario.assemble import GROUP, SIGNALS
from martensite.scenario.scenario import Scenario
from martensite.scenario.sections import REFERENCE, SECTIONS
from martensite.signals.base import DRIVE, WAVEFORMS


def relax_surroundings(scenario: Scenario, one: ChangedScenario) -> Iterator[ChangedScenario]:
    """Yield a candidate, then candidates that keep fewer sections around the system."""
    yield one
    less = _keep_single_port(scenario, one)
    if less is not None:
        yield less
    around = [name for name in SECTIONS if name in one.document]
    if around and less is None and _list_kinds(one.document) != _list_kinds(toml_document(scenario.text)):
        bare = deepcopy(one)
        for name in around:
            del bare.document[name]
        _add_waveform(bare, scenario)
        bare.notes.append(f"Sections that do not fit the new part were removed: {', '.join(f'[{n}]' for n in around)}.")
        yield bare


def change_reference(scenario: Scenario, one: ChangedScenario, place: str) -> Iterator[ChangedScenario]:
    """Yield the candidates in which a controller follows an output of another unit."""
    name = place.partition(".")[2]
    path = f"references.{name}" if name else REFERENCE
    if documents.find_entry(one.document, f"{place}.{REFERENCE}") is not None:
        path = f"{place}.{REFERENCE}"
    for unit in dict.fromkeys(o.unit for o in reversed(scenario.system.outputs().values())):
        candidate = deepcopy(one)
        _change_levels(candidate, path, unit)
        candidate.notes.append(f"The reference has a start value in {unit}, the unit of this kind.")
        yield candidate


def _list_kinds(document: JsonTable) -> tuple[Any, ...]:
    drive = "driver" if "driver" in document else "drive"
    return tuple(documents.find_entry(document, f"{n}.kind") for n in ("mechanism", drive))


def _keep_single_port(scenario: Scenario, one: ChangedScenario) -> ChangedScenario | None:
    """Return the document without other ports and signals, for a mechanism without them; None if unchanged."""
    if GROUP not in one.document and SIGNALS not in one.document:
        return None
    candidate, drive = deepcopy(one), scenario.places.drive
    ports = documents.find_table(candidate.document, GROUP).values()
    waveforms = [documents.find_entry(port, f"{drive}.waveform") for port in ports]
    for name in (GROUP, SIGNALS, *SECTIONS):
        if name in candidate.document:
            del candidate.document[name]
            candidate.notes.append(f"[{name}] was taken out: it belonged to the other mechanism.")
    first = next((w for w in waveforms if w is not None), None)
    if first is not None:
        documents.put_entry(candidate.document, f"{drive}.waveform", first)
    _add_waveform(candidate, scenario)
    return candidate


def _add_waveform(one: ChangedScenario, scenario: Scenario) -> None:
    drive = scenario.places.drive
    path = f"{drive}.waveform"
    if documents.find_entry(one.document, path) is None:
        source = SOURCES[str(documents.find_entry(one.document, f"{drive}.{KIND}"))]
        _begin_waveform(one, path, source.unit)


def _begin_waveform(one: ChangedScenario, path: str, unit: str) -> None:
    cls = WAVEFORMS[WAVEFORMS.typical]
    filler = TableFiller(place_units(unit))
    documents.put_entry(one.document, path, filler.table(cls, WAVEFORMS, {}, path))
    one.assumed += filler.assumed


def change_source(one: ChangedScenario, scenario: Scenario, place: str, unit: str, cls: type[Parametrised]) -> None:
    """Set levels in the unit of the new source, and a cooling if the old source needed none."""
    new = str(getattr(cls, "unit", "1"))
    drive = place.rpartition(".")[2]
    places = [drive, *(f"{GROUP}.{name}.{drive}" for name in documents.find_table(one.document, GROUP))]
    if new != unit:
        for path in (f"{p}.waveform" for p in places):
            if documents.find_entry(one.document, path) is not None:
                _change_levels(one, path, new)
        one.notes.append("Levels of the drive are start values in its new unit.")
    if not getattr(cls, "sets_temperature", False):
        _add_cooling(one)


def _change_levels(one: ChangedScenario, path: str, unit: str) -> None:
    old = documents.find_table(one.document, path)
    cls = WAVEFORMS[str(old[KIND])]
    if cls.unit not in (None, unit) or "times" in cls.declarations:
        _begin_waveform(one, path, unit)
        return
    levels = [name for name, declared in cls.declarations.items() if declared.unit == DRIVE]
    rest = {key: value for key, value in old.items() if key not in levels}
    filler = TableFiller(place_units(unit))
    documents.put_entry(one.document, path, filler.table(cls, WAVEFORMS, rest, path))
    one.assumed += filler.assumed


def _add_cooling(one: ChangedScenario) -> None:
    path = "environment.cooling"
    if documents.find_entry(one.document, path) is None:
        cls = COOLING[COOLING.typical]
        filler = TableFiller()
        documents.put_entry(one.document, path, filler.table(cls, COOLING, {}, path))
        one.assumed += filler.assumed
