"""Interface of a check: a condition that must hold, or the guard cuts signals.

Every check has an alarm number. If several checks have cut, the guard reports the lowest number:

| alarm | check | condition |
| --- | --- | --- |
| 0 | | no alarm |
| 1 | `overheat` | a measured temperature is too high |
| 2 | `over-current` | a measured current is too large |
| 3 | `over-stress`, `over-force` | a measured stress or force is too large |
| 4 | `sensor-lost` | a reading is too old |
| 5 | `sensor-stuck` | a reading does not change, though the element is heated |
| 6 | `open-circuit` | no current is measured, though a signal is on |
| 7 | `mismatch` | two readings of one quantity differ |
| 8 | `thermal-bound` | the temperature bound of the element is above its limit |
| 9 | `low-confidence` | an observer has low confidence in its estimates |

Visible damage has the lowest numbers, then faults of sensors and wires, then possible damage. While a check
only limits a signal (answer `limit` of a guard) and no check has cut, the alarm is its number plus 100, such as 108.
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
"""Offset of an alarm number while a signal is limited and not cut."""
Column: TypeAlias = Sequence[Scalar]
Named: TypeAlias = Mapping[str, Scalar]


class CheckResult(NamedTuple):
    """Result of a check in one sample."""

    trips: Flag
    clears: Flag
    memory: Column


class AbstractCheck(Parametrised):
    """Interface of a check."""

    alarm: ClassVar[int] = 0
    size: ClassVar[int] = 0

    drives: tuple[str, ...] = text("drives whose signals the check cuts; default: all", default=())

    def cuts(self) -> tuple[str, ...]:
        """Return the names of the drives that the check cuts; empty for all drives."""
        return (self.drives,) if isinstance(self.drives, str) else self.drives

    def names(self) -> tuple[str, ...]:
        """Return the names of all drives that the check uses."""
        return self.cuts()

    def reads(self) -> tuple[str, ...]:
        """Return the names of the readings that the check needs."""
        return ()

    def rest(self, xp: Namespace, readings: Named) -> Column:
        """Return the memory before the first sample, `size` values."""
        return ()

    @abstractmethod
    def look(self, xp: Namespace, memory: Column, wanted: Named, readings: Named, dt: Scalar) -> CheckResult:
        """Check one sample.

        Args:
            xp: namespace.
            memory: memory after the previous sample, or from `rest`.
            wanted: signals by the name of the drive.
            readings: readings by name, and the age of each, `NAME.age` [s].
            dt: sample period [s].
        """

    def find_most(self, xp: Namespace, memory: Column, dt: Scalar) -> Named:
        """Return the largest allowed size of the next signal, by drive; empty if unknown."""
        return {}

    def remember_allowed(self, xp: Namespace, memory: Column, allowed: Named, dt: Scalar) -> Column:
        """Return the memory after the guard has decided the signals of the next period."""
        return memory

    def on(self, xp: Namespace, signals: Named, least: Scalar) -> Scalar:
        """Return 1 if a signal that the check cuts is larger than `least`, else 0."""
        chosen = [u for name, u in signals.items() if name in self.cuts() or not self.cuts()]
        state: Scalar = 0.0
        for signal in chosen:
            state = xp.where(xp.abs(signal) > least, 1.0, state)
        return state


class Checks(Members[AbstractCheck], init=False):
    """Checks by user-defined names."""

    noun, kind = "check", AbstractCheck
    registry = CHECKS


def alarm_names() -> dict[int, str]:
    """Return the names of the checks that raise each alarm number; `none` for 0."""
    alarms: dict[int, str] = {0: "none"}
    for name in CHECKS.names():
        number = CHECKS[name].alarm
        alarms[number] = f"{alarms[number]}, {name}" if number in alarms else name
    return dict(sorted(alarms.items()))
