"""Places of numbers in a scenario: their paths for `--set`, and their units.

A bench names parameters by component (`controllers.drive.law.high`), a scenario by section (`controller.high`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from martensite.base.parameters import Leaf, Parametrised
from martensite.scenario.assemble import DRIVE, scenario_path
from martensite.scenario.place_units import PlaceUnits


@dataclass
class Places:
    """Map from the numbers of a system or bench to the numbers of its scenario."""

    drive: str = DRIVE
    """Name of the section of the source."""
    scenario_prefixes: dict[str, str] = field(default_factory=dict[str, str])
    """Prefixes of paths in the scenario, by prefix in the bench."""
    scales: dict[str, PlaceUnits] = field(default_factory=dict[str, PlaceUnits])
    """Units of levels, by prefix of paths in the bench."""
    systems: set[str] = field(default_factory=set[str])
    """Prefixes of paths in the bench of whole systems."""

    def note(self, path: str, written: str, scales: PlaceUnits | None = None) -> None:
        """Note a part of the bench with its section and units."""
        self.scenario_prefixes[path] = written
        if scales is not None:
            self.scales[path] = scales

    def note_scales(self, path: str, part: Parametrised, scales: PlaceUnits) -> None:
        """Note the units of all components of a part that name a reading."""
        own = scales.within(type(part), part.__dict__)
        if own is not scales:
            self.scales[path] = own
        for name, child in part.children():
            self.note_scales(f"{path}.{name}", child, own)

    def note_system(self, path: str, written: str) -> None:
        """Note a system in the bench with its section."""
        self.scenario_prefixes[path] = written
        self.systems.add(path)

    def path(self, path: str) -> str:
        """Return the path in the scenario of a path in the system or bench."""
        begin = _find_longest(self.scenario_prefixes, path)
        if begin is None:
            return scenario_path(path, self.drive)
        rest = path[len(begin) :].removeprefix(".")
        if begin in self.systems:
            rest = scenario_path(rest, self.drive)
        return ".".join(filter(None, (self.scenario_prefixes[begin], rest)))

    def is_copy(self, path: str) -> bool:
        """Return true for a number of a model, which is a copy of the system."""
        begin = _find_longest(self.scenario_prefixes, path)
        return begin in self.systems and bool(self.scenario_prefixes[begin or ""])

    def unit(self, leaf: Leaf) -> str:
        """Return the unit of a number of the system or bench."""
        begin = _find_longest(self.scales, leaf.path)
        unit = None if begin is None else self.scales[begin].find_unit(leaf.declared)
        return unit or leaf.declared.unit


def _find_longest(begins: Iterable[str], path: str) -> str | None:
    return max((b for b in begins if path == b or path.startswith(f"{b}.")), key=len, default=None)
