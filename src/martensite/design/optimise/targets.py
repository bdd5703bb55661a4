"""Free numbers of a design: parameters of the system and levels of its waveforms.

Texts are those of `martensite.search.free_numbers`. What the system refuses to be anything between
whole numbers is searched as a whole number.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from martensite.actuators.assembly import AbstractSystem
from martensite.base import units
from martensite.base.errors import ParameterError, suggest_name
from martensite.search.free_numbers import FreeNumber, Target, build_free, find_targets, parse_free, read_free
from martensite.simulate.waveform_levels import PEAK, WaveformLevels


def list_targets(steering: WaveformLevels, written: Mapping[str, str] | None = None) -> list[Target]:
    """All numbers of a system and levels of its waveforms; `written` has the paths that differ in the scenario."""
    spelled = written or {}
    leaves = steering.system.leaves()
    found = [Target.from_leaf(leaf, spelled.get(leaf.path, leaf.path)) for leaf in leaves]
    names = {drive.name: drive.unit for drive in steering.system.drives()}
    for level in steering.available():
        path = name_level(level.drive, level.name)
        name, unit = spelled.get(path, path), names[level.drive]
        found.append(Target(name, path, unit, level.value, drive=level.drive, level=level))
    return found


def name_level(drive: str, name: str) -> str:
    """Return the name of a level of the waveform of a drive."""
    return f"{drive}.{PEAK}" if name == PEAK else f"{drive}.waveform.{name}"


def find_alike(name: str, known: Sequence[Target]) -> list[Target]:
    """Return the numbers that a path, or an ending of paths, names; several must be alike.

    Raises:
        ParameterError: there is none, or several that differ.
    """
    found = find_targets(name, known)
    if not found:
        endings = {c.name for c in known} | {c.name.rpartition(".")[2] for c in known}
        raise ParameterError(f"There is no number `{name}`. {_suggest_ending(name, endings)}")
    if len({(c.unit, c.value) for c in found}) > 1:
        listed = ", ".join(f"`{c.name}`" for c in found)
        raise ParameterError(f"`{name}` is ambiguous: {listed}.")
    return found


def _suggest_ending(name: str, endings: set[str]) -> str:
    """Return a suggestion, or where to find a list, which is long."""
    sentence = suggest_name(name, endings)
    if sentence.startswith("Valid"):
        return "`martensite params` lists those of every component."
    return sentence.partition(" Valid")[0]


def read_design_number(text: str, known: Sequence[Target], system: AbstractSystem) -> FreeNumber:
    """Read a free parameter from a text such as `element.diameter=0.05..0.5 mm`.

    Raises:
        ParameterError: the text is malformed, the name is unknown, or the bounds are not an interval.
        UnitError: a bound has another unit than the parameter.
    """
    name = parse_free(text)[0]
    found = find_alike(name, known)
    unit = found[0].unit
    wanted = read_free(text, unit, lambda words: units.parse_quantity(words, unit))
    free = build_free(wanted, found, found[0].name if len(found) == 1 else name)
    free = replace(free, whole=free.whole or (wanted.scale is None and _is_whole(system, free)))
    if free.whole and not free.low.is_integer() & free.high.is_integer():
        raise ParameterError(f"`{text}`: bounds of a whole number must be whole numbers.")
    return free


def _is_whole(system: AbstractSystem, free: FreeNumber) -> bool:
    """Return whether the system takes whole numbers only."""
    target = free.targets[0]
    if free.unit != "1" or target.level is not None or free.high < free.low + 1.0:
        return False
    whole = math.ceil(free.low)
    return _accepts_value(system, target.path, whole) and not _accepts_value(system, target.path, whole + 0.5)


def _accepts_value(system: AbstractSystem, path: str, value: float) -> bool:
    try:
        system.with_values({path: value})
    except ParameterError:
        return False
    return True
