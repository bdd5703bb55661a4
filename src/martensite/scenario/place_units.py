"""Units of numbers that have them from their place: signals of a drive, and readings.

A level of a waveform is in the unit of what it drives. Levels, differences and rates of a reading
are in the unit of the reading that their component, or one that it belongs to, names.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

from martensite.base import units
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import Declared, Parametrised
from martensite.signals.base import DRIVE


@dataclass(frozen=True)
class PlaceUnits:
    """Units of drive and readings at a place in the document."""

    drive: str = "1"
    """SI unit of the signal."""
    readings: Mapping[str, str] = field(default_factory=dict[str, str])
    """SI units of all readings, by name."""
    named: tuple[str, ...] = ()
    """Names of the readings that are meant."""
    controlled: str = ""
    """SI unit of the reading that a controller controls."""
    sampled: bool = False
    """True if gains are per sample."""

    def within(self, cls: type[Parametrised], texts: Mapping[str, Any]) -> PlaceUnits:
        """Return the units that apply inside a component with these texts."""
        measured, kind = texts.get("measured"), texts.get("gains_are")
        controlled = self.readings.get(measured, "") if isinstance(measured, str) else ""
        found = replace(
            self,
            named=named_readings(cls, texts) or self.named,
            drive=cls.unit_of_signal or self.drive,
            controlled=cls.unit_of_reading or controlled or self.controlled,
            sampled=self.sampled if kind is None else kind == "per-sample",
        )
        return self if found == self else found

    def unit(self, declared: Declared) -> str:
        """Return the SI unit of a number; 1, a number in SI, for readings of several units.

        Raises:
            ParameterError: no reading is named, or one that there is not.
        """
        found = self.known(declared)
        if found is not None:
            return found
        unknown = next((name for name in self.named if name not in self.readings), None)
        if unknown is None:
            raise ParameterError(f"No reading is named, in whose unit is: {declared.doc}.")
        raise ParameterError(f"There is no reading `{unknown}`. {suggest_name(unknown, self.readings)}")

    def known(self, declared: Declared) -> str | None:
        """Return the SI unit of a number, if there is the reading that it needs."""
        if declared.unit == DRIVE:
            return self.drive
        if declared.unit in units.OF_LOOPS:
            unit = units.GAIN if self.sampled and declared.unit in units.OF_GAINS else declared.unit
            known = self.controlled or unit == units.SIGNAL_RATE
            return units.of_loop(unit, self.drive, self.controlled) if known else None
        if declared.unit not in units.OF_READINGS:
            return declared.unit
        if not self.named or any(name not in self.readings for name in self.named):
            return None
        own = {units.of_reading(declared.unit, self.readings[name]) for name in self.named}
        return own.pop() if len(own) == 1 else "1"

    def label(self, declared: Declared) -> str:
        """Return the unit in which a person would rather read it; nothing if there is or is known none."""
        unit = units.choose_readable_unit(self.known(declared) or "1")
        return "" if unit == "1" else unit


def named_readings(cls: type[Parametrised], texts: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the names of the readings that a component names by its texts, if it does."""
    for name in cls.names_reading:
        found = texts.get(name, cls.declarations[name].default)
        rows = [found] if isinstance(found, str) else found
        named = tuple(cast("Sequence[Any]", rows)) if isinstance(rows, (list, tuple)) else ()
        named = tuple(str(one) for one in named if one)
        if named:
            return named
    return ()
