"""Where a scenario holds a number: the path by which `--set` reaches it, and its unit.

A bench calls things by their part in it, `controllers.drive.law.high`, a scenario by its
sections, `controller.high`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from martensite.io.assemble import DRIVE, scenario_path
from martensite.parameters import Leaf
from martensite.signals.base import DRIVE as DRIVE_UNIT


@dataclass
class Places:
    """From the numbers of a system, or of a bench, to those of its scenario."""

    drive: str = DRIVE
    """What the section of the source is called."""
    written: dict[str, str] = field(default_factory=dict[str, str])
    """Beginning of a path in the bench -> its beginning in the scenario."""
    units: dict[str, str] = field(default_factory=dict[str, str])
    """Beginning of a path in the bench -> unit of levels below it."""
    systems: set[str] = field(default_factory=set[str])
    """Beginnings of paths in the bench below which there is a system."""

    def note(self, path: str, written: str, unit: str = "") -> None:
        """A part of the bench, the section it is in, and the unit of levels in it."""
        self.written[path] = written
        if unit:
            self.units[path] = unit

    def note_system(self, path: str, written: str) -> None:
        """A system in the bench, and where the scenario describes it."""
        self.written[path] = written
        self.systems.add(path)

    def path(self, path: str) -> str:
        """The path in the scenario of a number at a path of the system or bench."""
        begin = _longest(self.written, path)
        if begin is None:
            return scenario_path(path, self.drive)
        rest = path[len(begin) :].removeprefix(".")
        if begin in self.systems:
            rest = scenario_path(rest, self.drive)
        return ".".join(filter(None, (self.written[begin], rest)))

    def is_copy(self, path: str) -> bool:
        """Whether a number belongs to another system than that of the scenario, to a model."""
        begin = _longest(self.written, path)
        return begin in self.systems and bool(self.written[begin or ""])

    def unit(self, leaf: Leaf) -> str:
        """The unit of a number of the system or bench; that of a level depends on its place."""
        begin = _longest(self.units, leaf.path)
        if leaf.declared.unit != DRIVE_UNIT or begin is None:
            return leaf.declared.unit
        return self.units[begin]


def _longest(known: dict[str, str], path: str) -> str | None:
    """The longest of some beginnings that a path has."""
    found = [begin for begin in known if path == begin or path.startswith(f"{begin}.")]
    return max(found, key=len, default=None)
