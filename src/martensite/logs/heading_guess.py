"""Guess of the meaning of a column heading: a known name and its unit.

`T [degC]`, `temp (C)`, `Time_s`, `F/N`, `U in V`, `strain %` are all read. The strict reader
(`martensite.logs.exact_tables`) does not guess; `martensite.logs.lab_files` reports its guesses. A missing unit is not
guessed here.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

from martensite.base import units
from martensite.base.errors import UnitError
from martensite.logs.layout import CANONICAL, CLOCK, IGNORED, find_quantity
from martensite.signals.base import DRIVE

SPELLINGS = {
    "degC": ("degC", "deg_C", "°C", "ºC", "C", "deg C", "deg c", "degrees c", "celsius", "℃", "<temp> (C)"),
    "degF": ("degF", "°F", "ºF", "F", "deg F", "fahrenheit"),
    "K": ("K", "kelvin"),
    "s": ("s", "sec", "sec.", "secs", "second", "seconds", "sekunden"),
    "ms": ("ms", "msec", "millisecond", "milliseconds"),
    "us": ("us", "µs", "μs"),
    "min": ("min", "minute", "minutes"),
    "hour": ("h", "hr", "hour", "hours"),
    "N": ("N", "newton"),
    "mN": ("mN",),
    "kN": ("kN",),
    "gf": ("gf", "g", "gm", "gram", "grams", "gramf"),
    "kgf": ("kgf", "kg", "kp"),
    "lbf": ("lbf", "lb", "lbs"),
    "ozf": ("ozf", "oz"),
    "Pa": ("Pa",),
    "kPa": ("kPa",),
    "MPa": ("MPa", "N/mm^2", "N/mm²", "N/mm2"),
    "GPa": ("GPa",),
    "psi": ("psi",),
    "ksi": ("ksi",),
    "bar": ("bar",),
    "%": ("%", "percent", "pct"),
    "1": ("1", "-", "mm/mm", "m/m", "in/in"),
    "ppm": ("ppm", "microstrain", "ustrain", "µstrain", "μstrain", "µε", "με", "ue"),
    "m": ("m", "meter", "metre"),
    "mm": ("mm",),
    "cm": ("cm",),
    "um": ("um", "µm", "μm", "micron", "microns"),
    "in": ("in", "in.", "inch", "inches"),
    "thou": ("thou", "mil", "mils"),
    "ohm": ("ohm", "ohms", "Ω", "Ω"),
    "mohm": ("mohm", "mΩ", "mΩ"),
    "kohm": ("kohm", "kOhm", "kΩ", "kΩ"),
    "A": ("A", "amp", "amps", "ampere", "ADC", "A DC"),
    "mA": ("mA", "mA DC", "mADC"),
    "uA": ("uA", "µA", "μA"),
    "V": ("V", "volt", "volts", "VDC", "V DC", "Vdc"),
    "mV": ("mV", "mV DC", "mVDC"),
    "W": ("W", "watt", "watts"),
    "mW": ("mW",),
    "rad": ("rad",),
    "deg": ("deg", "°"),
    "rad/s": ("rad/s",),
    "rpm": ("rpm", "1/min"),
}
"""Unit of this package -> other spellings."""
BY_UNIT = {
    "s": "time",
    "K": "temperature",
    "Pa": "stress",
    "N": "force",
    "ohm": "resistance",
    "A": "current",
    "V": "voltage",
    "W": "power",
    "m": "position",
    "rad": "angle",
    "rad/s": "rotor_speed",
}
"""SI unit -> column, for headings without a known name."""

_BRACKETS = re.compile(r"^(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]\s*$")
_APART = re.compile(r"^(.*\S)\s*/\s*(\S.*)$|^(.*\S)\s+in\s+(\S+)$|^(.*\S)[\s_]+(\S+?)$")
_PORT = re.compile(r"^([A-Za-z_]\w*\.)(\w+)$")
STATISTIC = re.compile(r"[\s_](?:median|mean|avg|average|max|min|rms|std|sd)$", re.IGNORECASE)
"""Words after a unit, as in `dx_um_median`."""
HEAT = re.compile(r"heat[\s_]*flow|w[äa]rmestrom|^dsc\b", re.IGNORECASE)
"""Headings of a calorimeter's signal, whose watts are no drive power."""
_NUMBERED = ("channel", "ch", "kanal", "sensor", "probe", "input", "trace", "analog", "digital")
"""Words before a letter that is a channel name, not a unit: `Channel A`."""


@dataclass(frozen=True)
class Guess:
    """Guessed meaning of a column; empty if unknown."""

    name: str
    """Known column (`layout.CANONICAL`), optionally with a port; may be empty."""
    unit: str
    """Unit as `martensite.base.units` reads it; empty if the heading has no unit."""
    has_words: bool = True
    """True if a word of the heading names the quantity; False if only the unit does."""


def guess_heading(heading: str) -> Guess:
    """Return the guessed meaning of a heading."""
    words, spelling = part_heading(heading.strip())
    unit = _find_unit(spelling)
    if not unit and _BRACKETS.match(heading.strip()) and _is_unit(spelling):
        unit = spelling  # W/g
    match = _PORT.match(words)
    port, plain = (match[1], match[2]) if match else ("", words)
    named = _find_named(plain, unit)
    name = named or ("" if HEAT.search(plain) else _name_by_unit(unit))
    return Guess(f"{port.lower()}{name}" if name else "", unit, bool(named))


def usual_units(name: str) -> list[str]:
    """Return the allowed units of a known column, the usual unit first."""
    wanted = CANONICAL.get(name.rpartition(".")[2])
    if wanted is None:
        return []
    fitting = [s for s in SPELLINGS if _is_convertible(s, wanted)]
    first = "%" if name == "strain" else "V" if wanted == DRIVE else units.choose_readable_unit(wanted)
    clock = [CLOCK] if name == "time" else []
    return [*sorted(fitting, key=lambda s: s != first), *clock]


def find_worded_unit(heading: str, name: str) -> str:
    """Return the unit after a number in a heading, as in `V_1300V_05Hz`, if it fits a known column; else empty."""
    for part in re.split(r"[\s_,;]+", heading):
        match = re.fullmatch(r"\d+(?:[.p]\d+)?([A-Za-zµ°%]+)", part)
        unit = find_listed(match[1]) if match else ""
        if unit and _is_convertible(unit, CANONICAL.get(name, "")):
            return unit
    return ""


def part_heading(heading: str) -> tuple[str, str]:
    """Return the name and the possible unit in a heading."""
    reduced = STATISTIC.sub("", heading)
    if reduced != heading and part_heading(reduced)[1]:
        words, unit = part_heading(reduced)
        return f"{words}{heading[len(reduced) :]}", unit
    match = _BRACKETS.match(heading)
    if match is not None:
        return match[1], match[2]
    match = _APART.match(heading)
    if match is not None:
        words, last = (part for part in match.groups() if part is not None)
        if find_listed(last) and not last.isdigit() and words.lower() not in _NUMBERED:
            return words, last
    if heading.endswith("%"):
        return heading[:-1], "%"
    return heading, ""


def _find_unit(spelling: str) -> str:
    """Return a unit in the spelling of this package; an unlisted but valid spelling unchanged."""
    spelling = spelling.strip()
    if not spelling or spelling == IGNORED:
        return "1" if spelling else ""
    if spelling == CLOCK:
        return CLOCK
    listed = find_listed(spelling)
    if listed:
        return listed
    is_unit = len(spelling) > 1 and any(_is_convertible(spelling, si) for si in (*BY_UNIT, "1", "m/s", "Hz"))
    return spelling if is_unit else ""  # single letters that are not listed are physical constants


@lru_cache(maxsize=4096)
def find_listed(spelling: str) -> str:
    """Return the listed unit of a spelling; empty for other texts."""
    spelling = spelling.strip()
    for name, others in SPELLINGS.items():
        if spelling in others or (len(spelling) > 2 and spelling.lower() in others):
            return name
    return ""


def _name_by_unit(unit: str) -> str:
    """Return the column of a unit; empty for fractions, because these convert to angles."""
    if not unit or (_is_convertible(unit, "1") and unit not in SPELLINGS["rad"] + SPELLINGS["deg"]):
        return ""
    return next((name for si, name in BY_UNIT.items() if _is_convertible(unit, si)), "")


def _find_named(words: str, unit: str) -> str:
    """Return the known column named by some words, if its unit agrees; else empty."""
    plain = re.sub(r"[\s-]+", "_", words.strip())
    if plain.lower() in CANONICAL:
        return plain.lower()
    parts = [re.sub(r"\d+$", "", part) for part in (plain, *re.split(r"[_:,.]+", plain))]
    for part in parts:
        name = find_quantity(part, lambda one: not unit or _is_convertible(unit, CANONICAL[one]))
        if name:
            return name
    return ""


def _is_unit(spelling: str) -> bool:
    if len(spelling) == 1:
        return False
    try:
        units.require_unit(spelling)
    except UnitError:
        return False
    return bool(re.match(r"[A-Za-zµ%°]", spelling))


def _is_convertible(spelling: str, wanted: str) -> bool:
    options = ("V", "A", "W", "K") if wanted == DRIVE else (wanted,)
    for unit in options:
        try:
            units.find_conversion(spelling, unit)
        except UnitError:
            continue
        return True
    return False
