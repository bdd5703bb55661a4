"""Units that depend on the place of a number in a scenario: signals of a drive, and readings.

A level of a waveform has the unit of its drive. Levels, differences and rates of a reading have the unit of the reading
that the component, or an outer one, names.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

from martensite.base import units
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import FieldDeclaration, Parametrised
from martensite.signals.base import DRIVE


@dataclass(frozen=True)
class PlaceUnits:
    """Units of drive and readings at a place in the document."""

    drive: str = "1"
    """SI unit of the signal."""
    readings: Mapping[str, str] = field(default_factory=dict[str, str])
    """SI units of all readings, by name."""
    reading_names: tuple[str, ...] = ()
    """Names of the readings in use."""
    controlled: str = ""
    """SI unit of the controlled reading."""
    sampled: bool = False
    """True if gains are per sample."""

    def within(self, cls: type[Parametrised], texts: Mapping[str, Any]) -> PlaceUnits:
        """Return the units inside a component with these texts."""
        measured, kind = texts.get("measured"), texts.get("gains_are")
        controlled = self.readings.get(measured, "") if isinstance(measured, str) else ""
        units_here = replace(
            self,
            reading_names=list_named_readings(cls, texts) or self.reading_names,
            drive=cls.unit_of_signal or self.drive,
            controlled=cls.unit_of_reading or controlled or self.controlled,
            sampled=self.sampled if kind is None else kind == "per-sample",
        )
        return self if units_here == self else units_here

    def unit(self, declared: FieldDeclaration) -> str:
        """Return the SI unit of a number; 1 for readings of several units.

        Raises:
            ParameterError: no reading is named, or an unknown one.
        """
        unit = self.find_unit(declared)
        if unit is not None:
            return unit
        unknown = next((name for name in self.reading_names if name not in self.readings), None)
        if unknown is None:
            raise ParameterError(f"No reading is named, in whose unit is: {declared.doc}.")
        raise ParameterError(f"There is no reading `{unknown}`. {suggest_name(unknown, self.readings)}")

    def find_unit(self, declared: FieldDeclaration) -> str | None:
        """Return the SI unit of a number, or None if its reading is unknown."""
        if declared.unit == DRIVE:
            return self.drive
        if declared.unit in units.OF_LOOPS:
            unit = units.GAIN if self.sampled and declared.unit in units.OF_GAINS else declared.unit
            determined = self.controlled or unit == units.SIGNAL_RATE
            return units.of_loop(unit, self.drive, self.controlled) if determined else None
        if declared.unit not in units.OF_READINGS:
            return declared.unit
        if not self.reading_names or any(name not in self.readings for name in self.reading_names):
            return None
        own = {units.of_reading(declared.unit, self.readings[name]) for name in self.reading_names}
        return own.pop() if len(own) == 1 else "1"

    def label(self, declared: FieldDeclaration) -> str:
        """Return the familiar unit of a number; empty without a known unit."""
        unit = units.choose_readable_unit(self.find_unit(declared) or "1")
        return "" if unit == "1" else unit


def list_named_readings(cls: type[Parametrised], texts: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the names of the readings that the texts of a component name."""
    for name in cls.names_reading:
        value = texts.get(name, cls.declarations[name].default)
        rows = [value] if isinstance(value, str) else value
        named = tuple(cast("Sequence[Any]", rows)) if isinstance(rows, (list, tuple)) else ()
        named = tuple(str(one) for one in named if one)
        if named:
            return named
    return ()
