"""Meaning of the columns of a measured table: names, units and layout of the file.

A heading is a name with its unit in brackets: `temperature [degC]`, `stress (MPa)`. Known names have a fixed SI unit; a
missing unit is an error, because a guess can be wrong. `-` skips a column, and the unit `clock` reads times of day
(17:27:33) as seconds since the first row.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

from martensite.base import units
from martensite.base.errors import DataError, UnitError
from martensite.signals.base import DRIVE


class Quantity(NamedTuple):
    """Quantity in a column."""

    unit: str
    """SI unit; for the drive it depends on the source."""
    words: tuple[str, ...] = ()
    """Words for it in headings; single letters are case-sensitive."""
    role: str = ""
    """`drive`, `shape` (motion), or `load` in an experiment; the most informative of each role come first."""


QUANTITIES = {
    "time": Quantity("s", ("t", "zeit", "elapsed", "timestamp", "clock", "x_value", "millis", "micros")),
    "temperature": Quantity("K", ("temp", "temp.", "thermocouple", "theta", "temperatur", "tc", "T")),
    "strain": Quantity("1", ("eps", "epsilon", "ε", "dehnung"), "shape"),
    "stress": Quantity("Pa", ("sigma", "σ", "spannung_mech"), "load"),
    "force": Quantity("N", ("load", "kraft", "standardkraft", "loadcell", "weight", "tension", "F"), "load"),
    "elongation": Quantity("m", ("extension",), "shape"),
    "crosshead": Quantity("m", role="shape"),
    "lift": Quantity("m", role="shape"),
    "position": Quantity(
        "m",
        (
            "weg",
            "standardweg",
            "pos",
            "displacement",
            "disp",
            "stroke",
            "travel",
            "deflection",
            "contraction",
            "laser",
            "x",
        ),
        "shape",
    ),
    "resistance": Quantity("ohm", ("res", "R")),
    "duty": Quantity("1", ("pwm", "duty_cycle"), "drive"),
    "voltage": Quantity("V", ("volt", "volts", "voltage_drop", "U", "V", "u", "v"), "drive"),
    "current": Quantity("A", ("strom", "amps", "I", "i"), "drive"),
    "power": Quantity("W", ("leistung", "P"), "drive"),
    "drive": Quantity(DRIVE),
    "martensite_fraction": Quantity("1", ("martensite", "xi", "ξ")),
    "rotor_speed": Quantity("rad/s", ("speed", "omega", "rpm")),
    "angle": Quantity("rad", ("winkel", "phi", "φ")),
    "rotor_angle": Quantity("rad"),
    "motor_current": Quantity("A"),
}
"""Known column -> quantity; also with a port, as in `protagonist.temperature`."""
CANONICAL = {name: one.unit for name, one in QUANTITIES.items()}
"""Known column -> its SI unit."""
DRIVEN_BY = ("V", "A", "W", "K")
CLOCK = "clock"
IGNORED = "-"

_HEADING = re.compile(r"^\s*([^\[(]*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\s*$")
_UNIT = re.compile(r"^[\w%°(]([\w%°·^*/(). -]*[\w%)])?$")


@dataclass(frozen=True)
class FileColumn:
    """Column of a file: name, unit in the file, SI unit."""

    name: str
    spelling: str
    unit: str


@dataclass(frozen=True)
class Layout:
    """Layout of a file without usable headings."""

    columns: tuple[str, ...]
    """Headings, one per column of the file."""
    separator: str = "auto"
    """`auto`, `comma`, `semicolon`, `tab` or `whitespace`."""
    skip: int = 0
    """Lines to skip at the beginning."""
    drop: bool = False
    """Drop and count rows that are unreadable or repeat the time before."""


def find_quantity(words: str, fits: Callable[[str], bool] = lambda _: True) -> str:
    """Return the known, fitting column for a word; else empty."""
    for name, one in QUANTITIES.items():
        named = words in one.words or (len(words) > 1 and words.lower() in (name, *one.words))
        if named and name != "drive" and fits(name):  # `temp drive [V]` is a voltage
            return name
    return ""


def list_quantities(role: str) -> tuple[str, ...]:
    """Return the known columns of a role."""
    return tuple(name for name, one in QUANTITIES.items() if one.role == role)


def read_headings(headings: Iterable[str], where: str) -> list[FileColumn]:
    """Return the meanings of the headings of a table.

    Raises:
        DataError: a heading is empty or repeated, or its unit is missing or does not fit.
    """
    columns: list[FileColumn] = []
    for number, heading in enumerate(headings, start=1):
        column = _read_heading(heading, number, where)
        if column.name != IGNORED and any(column.name == c.name for c in columns):
            raise DataError(f"{where} has two columns `{column.name}`; rename one of them.")
        columns.append(column)
    return columns


def name_column(heading: str) -> str:
    """Return the name in a heading."""
    return heading.partition("[")[0].strip().lower()


def _read_heading(heading: str, number: int, where: str) -> FileColumn:
    match = _HEADING.match(heading)
    if match is None or not match[1]:
        raise DataError(
            f"{where}: heading `{heading.strip()}` of column {number} is not a name with a unit; "
            "write for example `temperature [degC]`."
        )
    if match[1] == IGNORED:
        return FileColumn(IGNORED, "1", "1")
    name, spelling = re.sub(r"[\s-]+", "_", match[1].lower()), match[2] or ""
    spelling = "1" if spelling == "-" else spelling
    unit = _find_known_unit(name)
    if not spelling and unit not in (None, "1"):
        raise DataError(f"{where}: column `{name}` has no unit; write for example `{name} [{_find_usual_unit(unit)}]`.")
    if name == "time" and spelling == CLOCK:
        return FileColumn(name, CLOCK, "s")
    return FileColumn(name, spelling or "1", _si_unit(name, spelling or "1", where))


def _find_known_unit(name: str) -> str | None:
    return CANONICAL.get(name.rpartition(".")[2])


def _si_unit(name: str, spelling: str, where: str) -> str:
    """Return the SI unit of a column, if its unit can be converted."""
    wanted = _find_known_unit(name)
    if wanted is None:
        declared = {unit for unit, _, _ in units.EVERYDAY.values()}
        if not spelling.endswith("Hz"):  # rpm and rad/s are no frequencies
            declared.discard("Hz")
        return _first_fitting(spelling, sorted(declared))
    if wanted == DRIVE:
        unit = _first_fitting(spelling, DRIVEN_BY)
        if unit in DRIVEN_BY:
            return unit
        fault = f"The unit `{spelling}` is none of volt, ampere, watt and kelvin."
    else:
        fault = _describe_misfit(spelling, wanted)
        if not fault:
            return wanted
    raise DataError(f"{where}, column `{name}`: {fault} Write for example `{name} [{_find_usual_unit(wanted)}]`.")


def _first_fitting(spelling: str, candidates: Iterable[str]) -> str:
    """Return the first SI unit that a unit converts to; else the unit itself."""
    return next((unit for unit in candidates if not _describe_misfit(spelling, unit)), spelling)


def _describe_misfit(spelling: str, unit: str) -> str:
    if not _UNIT.match(spelling):
        return f"`{spelling}` is not a known unit; `{unit}` is expected."
    try:
        units.to_si(1.0, spelling, unit)
    except UnitError as error:
        return str(error)
    return ""


def _find_usual_unit(unit: str | None) -> str:
    return "V" if unit in (None, DRIVE) else units.choose_readable_unit(unit)
