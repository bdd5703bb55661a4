"""The contract of a check: one thing that must hold, or signals are cut.

Every check has the number of its alarm. When several have cut, the lowest number is shown:

| alarm | check | what is wrong |
| --- | --- | --- |
| 0 | | nothing |
| 1 | `overheat` | a measured temperature is too high |
| 2 | `over-current` | a measured current is too large |
| 3 | `over-stress`, `over-force` | a measured stress or force is too large |
| 4 | `sensor-lost` | a reading is too old |
| 5 | `sensor-stuck` | a reading does not change, though the element is heated |
| 6 | `open-circuit` | no current is measured, though a signal is on |
| 7 | `mismatch` | two readings of the same thing differ |
| 8 | `thermal-bound` | by its own bound the element may be too hot |
| 9 | `low-confidence` | an observer has no trust in what it estimates |

Visible damage comes first, then faults of sensors and wires, last possible damage. While a check
only limits a signal (answer `limit` of a guard), and none has cut, its number is shown beyond 100: 108.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import ClassVar, NamedTuple, TypeAlias

from martensite.actuators.assembly import Members
from martensite.base.parameters import Parametrised, text
from martensite.base.registry import Registry
from martensite.kernels.namespace import Flag, Namespace, Scalar

CHECKS: Registry[AbstractCheck] = Registry("check", "martensite.control.checks", typical="overheat")
LIMITED = 100
"""Number that is added to an alarm while a signal is limited and not cut."""
Column: TypeAlias = Sequence[Scalar]
Named: TypeAlias = Mapping[str, Scalar]


class Looked(NamedTuple):
    """Result of a check in one sample."""

    trips: Flag
    """Something is wrong: signals must be cut."""
    clears: Flag
    """All is well: signals that were cut may come back."""
    memory: Column


class AbstractCheck(Parametrised):
    """Interface of a check."""

    alarm: ClassVar[int] = 0
    """Number of its alarm."""
    size: ClassVar[int] = 0
    """Numbers that it remembers."""

    drives: tuple[str, ...] = text("drives whose signals it cuts; all if none", default=())

    def cuts(self) -> tuple[str, ...]:
        """Return the names of the drives that it cuts; none for all."""
        return (self.drives,) if isinstance(self.drives, str) else self.drives

    def names(self) -> tuple[str, ...]:
        """Return the names of all drives that it speaks of."""
        return self.cuts()

    def reads(self) -> tuple[str, ...]:
        """Return the names of the readings that it needs."""
        return ()

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """Return the memory before the first sample, `size` numbers."""
        return ()

    @abstractmethod
    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> Looked:
        """Check one sample.

        Args:
            xp: namespace.
            memory: of the sample before, or of `rest`.
            wanted: signals by the name of the drive.
            readings: by name, and the age of each, `NAME.age` [s].
            dt: length of a period [s].
        """

    def find_most(self, xp: Namespace, memory: Column, dt: Scalar) -> Named:
        """Return the sizes of the largest allowed signals for the next period, by drive; empty if unknown."""
        return {}

    def remember_allowed(self, xp: Namespace, memory: Column, allowed: Named, dt: Scalar) -> Column:
        """Return the memory after the decision which signals pass for the next period."""
        return memory

    def on(self, xp: Namespace, signals: Named, least: Scalar) -> Scalar:
        """1 if one of the signals that it cuts is larger than the least one, else 0."""
        chosen = [u for name, u in signals.items() if name in self.cuts() or not self.cuts()]
        found: Scalar = 0.0
        for one in chosen:
            found = xp.where(xp.abs(one) > least, 1.0, found)
        return found


class Checks(Members[AbstractCheck], init=False):
    """Checks by names of the user's own."""

    noun, kind = "check", AbstractCheck
    registry = CHECKS


def alarm_names() -> dict[int, str]:
    """Return the number of an alarm -> names of the checks that raise it; `none` for 0."""
    found: dict[int, str] = {0: "none"}
    for name in CHECKS.names():
        number = CHECKS[name].alarm
        found[number] = f"{found[number]}, {name}" if number in found else name
    return dict(sorted(found.items()))
