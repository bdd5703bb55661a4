"""Free parameters of a design: parameters of the system and levels of its waveforms.

Texts are those of `martensite.search.free_text`. A parameter for which the system refuses fractions is a whole number.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError
from martensite.search.free_numbers import FreeNumber, SearchRange, Target, build_free, find_alike
from martensite.search.free_text import parse_free
from martensite.simulate.waveform_levels import PEAK, WaveformLevels


def list_targets(steering: WaveformLevels, scenario_paths: Mapping[str, str] | None = None) -> list[Target]:
    """Return all parameters of a system and levels of its waveforms; `scenario_paths` has paths in the scenario."""
    spelled = scenario_paths or {}
    leaves = steering.system.leaves()
    targets = [Target.from_leaf(leaf, spelled.get(leaf.path, leaf.path)) for leaf in leaves]
    names = {drive.name: drive.unit for drive in steering.system.drives()}
    for level in steering.available():
        path = name_level(level.drive, level.name)
        name, unit = spelled.get(path, path), names[level.drive]
        targets.append(Target(name, path, unit, level.value, drive=level.drive, level=level))
    return targets


def name_level(drive: str, name: str) -> str:
    """Return the name of a level of the waveform of a drive."""
    return f"{drive}.{PEAK}" if name == PEAK else f"{drive}.waveform.{name}"


def read_design_number(text: str, targets: Sequence[Target], system: AbstractSystem) -> FreeNumber:
    """Return the free parameter of a text such as `element.diameter=0.05..0.5 mm`.

    Raises:
        ParameterError: the text is malformed, the name is unknown, or the bounds are not an interval.
        UnitError: a bound has another unit than the parameter.
    """
    words = parse_free(text)
    alike = find_alike(words.name, targets)
    wanted = SearchRange.read(words, alike[0].unit)
    free = build_free(wanted, alike, alike[0].name if len(alike) == 1 else words.name)
    free = replace(free, whole=free.whole or (wanted.scale is None and _is_whole(system, free)))
    if free.whole and not free.low.is_integer() & free.high.is_integer():
        raise ParameterError(f"`{text}`: bounds of a whole number must be whole numbers.")
    return free


def _is_whole(system: AbstractSystem, free: FreeNumber) -> bool:
    """Return true if the system accepts whole numbers only."""
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
