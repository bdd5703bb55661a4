"""Numbers of a scenario that can be varied."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from martensite.scenario.assemble import waveform_path
from martensite.scenario.place_units import PlaceUnits
from martensite.search.free_numbers import Target
from martensite.simulate.drive_waveforms import by_name

if TYPE_CHECKING:
    from martensite.control.loop.bench import Bench
    from martensite.scenario.scenario import Scenario

SWITCHES = "automatic_from", "automatic_until"
"""Numbers of a bench that are played and not compiled."""


def list_targets(scenario: Scenario) -> dict[str, Target]:
    """Return every variable number of a scenario by its path in the scenario."""
    references = _list_references(scenario.bench) if scenario.bench else {}
    targets = [*_list_system_targets(scenario, references), *_list_waveform_targets(scenario)]
    return {target.name: target for target in targets}


def _list_system_targets(scenario: Scenario, references: Mapping[str, str]) -> Iterator[Target]:
    """Yield the numbers of the system or bench; numbers of a reference belong to its waveform."""
    for leaf in scenario.whole.leaves():
        name, unit = scenario.places.path(leaf.path), scenario.places.unit(leaf)
        if scenario.places.is_copy(leaf.path) or not math.isfinite(leaf.value):
            continue
        if name.rpartition(".")[2] in SWITCHES:
            continue
        begin = next((b for b in references if leaf.path.startswith(b)), None)
        drive = None if begin is None else references[begin]
        path = leaf.path.removeprefix(begin or "")
        yield Target(name, path, unit, float(leaf.value), leaf.declared.doc, drive)


def _list_references(bench: Bench) -> dict[str, str]:
    """Return the name of a played waveform by the prefix of its paths in the bench."""
    from martensite.control.loop.names import list_hands, list_references

    members = bench.controllers.members()
    names = {f"controllers.{one}.reference.": name for one, name in zip(members, list_references(bench), strict=True)}
    return names | {f"controllers.{one}.manual.signal.": name for one, (name, _) in list_hands(bench).items()}


def _list_waveform_targets(scenario: Scenario) -> Iterator[Target]:
    """Yield the numbers of the waveforms."""
    signals = {drive.name: drive.unit for drive in scenario.system.drives()}
    played: Mapping[str, Any] = by_name(scenario.system, scenario.waveform)
    for name, waveform in played.items():
        begin = waveform_path(scenario.system, name, scenario.places.drive)
        for leaf in waveform.leaves():
            if math.isfinite(leaf.value):
                unit = PlaceUnits(signals[name]).unit(leaf.declared)
                words = leaf.declared.doc
                yield Target(begin + leaf.path, leaf.path, unit, float(leaf.value), words, name)
