"""Place of every number in a scenario: the path for `--set`, and its unit.

A bench names parameters by component, `controllers.drive.law.high`; a scenario by section, `controller.high`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from martensite.base.parameters import Leaf, Parametrised
from martensite.scenario.assemble import DRIVE, scenario_path
from martensite.scenario.place_units import PlaceUnits


@dataclass
class Places:
    """From the numbers of a system, or of a bench, to those of its scenario."""

    drive: str = DRIVE
    """Name of the section of the source."""
    written: dict[str, str] = field(default_factory=dict[str, str])
    """Beginning of a path in the bench -> its beginning in the scenario."""
    scales: dict[str, PlaceUnits] = field(default_factory=dict[str, PlaceUnits])
    """Beginning of a path in the bench -> units of levels below it."""
    systems: set[str] = field(default_factory=set[str])
    """Beginnings of paths in the bench below which there is a system."""

    def note(self, path: str, written: str, scales: PlaceUnits | None = None) -> None:
        """A part of the bench, the section it is in, and the units of levels in it."""
        self.written[path] = written
        if scales is not None:
            self.scales[path] = scales

    def note_scales(self, path: str, part: Parametrised, scales: PlaceUnits) -> None:
        """The units of levels in what names a reading: a part of the bench, or its components."""
        own = scales.within(type(part), part.__dict__)
        if own is not scales:
            self.scales[path] = own
        for name, child in part.children():
            self.note_scales(f"{path}.{name}", child, own)

    def note_system(self, path: str, written: str) -> None:
        """A system in the bench, and where the scenario describes it."""
        self.written[path] = written
        self.systems.add(path)

    def path(self, path: str) -> str:
        """Return the path in the scenario of a number at a path of the system or bench."""
        begin = _find_longest(self.written, path)
        if begin is None:
            return scenario_path(path, self.drive)
        rest = path[len(begin) :].removeprefix(".")
        if begin in self.systems:
            rest = scenario_path(rest, self.drive)
        return ".".join(filter(None, (self.written[begin], rest)))

    def is_copy(self, path: str) -> bool:
        """Return whether a number belongs to another system than that of the scenario, to a model."""
        begin = _find_longest(self.written, path)
        return begin in self.systems and bool(self.written[begin or ""])

    def unit(self, leaf: Leaf) -> str:
        """Return the unit of a number of the system or bench; that of a level depends on its place."""
        begin = _find_longest(self.scales, leaf.path)
        known = None if begin is None else self.scales[begin].known(leaf.declared)
        return known or leaf.declared.unit


def _find_longest(known: Iterable[str], path: str) -> str | None:
    found = [begin for begin in known if path == begin or path.startswith(f"{begin}.")]
    return max(found, key=len, default=None)
