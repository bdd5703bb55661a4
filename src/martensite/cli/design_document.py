"""A design as a scenario: what its numbers are called there, and the document with them."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from martensite.base.errors import InputError

if TYPE_CHECKING:
    from martensite.design.optimise.optimised_design import OptimisedDesign
    from martensite.scenario.scenario import Scenario
    from martensite.search.free_numbers import Target


def name_targets(scenario: Scenario) -> dict[str, str]:
    """Path in the system of every number that may be free -> its path in the scenario."""
    from martensite.design.optimise.targets import name_level
    from martensite.scenario.assemble import waveform_path
    from martensite.simulate.waveform_levels import PEAK, WaveformLevels

    system, places = scenario.system, scenario.places
    found = {leaf.path: places.path(leaf.path) for leaf in system.leaves()}
    steering = WaveformLevels(system, scenario.waveform, scenario.duration)
    for level in steering.available():
        before = waveform_path(system, level.drive, places.drive)
        if level.name == PEAK:
            before = before.removesuffix("waveform.")
        found[name_level(level.drive, level.name)] = before + level.name
    return found


def require_written(scenario: Scenario, free: Sequence[str]) -> None:
    """Raise `InputError` if a peak is free whose waveform the scenario does not hold itself."""
    from martensite.simulate.waveform_levels import PEAK

    for text in free:
        name = text.partition("=")[0].strip()
        before, _, last = name.rpartition(".")
        if last == PEAK and isinstance(_find_waveform(scenario, f"{before}.").get("file"), str):
            raise InputError(
                f"`{name}` is the peak of a waveform in a file of its own, so no scenario can be "
                "written with another; leave out --save."
            )


def write_design(found: OptimisedDesign, scenario: Scenario) -> str:
    """The scenario with the numbers found, as TOML."""
    from martensite.scenario.overrides import as_toml, change_document

    numbers: dict[str, Any] = {}
    for one, value in zip(found.question.free, found.numbers, strict=True):
        for target in one.targets:
            numbers |= _write_settings(target, value, scenario, whole=one.whole)
    document = change_document(tomllib.loads(scenario.text), numbers)
    sense = "most" if found.question.most else "least"
    goal = f"# designed for the {sense} {found.question.goal.words}"
    limits = [f"# subject to {one.words}" for one in found.question.subject]
    missed = [f"# NOT KEPT: {words}" for words in found.missed]
    return "\n".join([goal, *limits, *missed, "", as_toml(document)])


def _write_settings(target: Target, value: float, scenario: Scenario, *, whole: bool) -> dict[str, Any]:
    """What a number is in the scenario: by path, as text with a unit."""
    from martensite.scenario.exact_text import exact_text
    from martensite.simulate.waveform_levels import PEAK

    if target.level is not None and target.level.name == PEAK:
        return _scale_levels(target, value / target.value, scenario)
    if target.unit == "1":
        return {target.name: int(value) if whole else value}
    return {target.name: exact_text(value, target.unit)}


def _scale_levels(target: Target, factor: float, scenario: Scenario) -> dict[str, Any]:
    """All levels of a waveform, scaled."""
    from martensite.base import units
    from martensite.scenario.exact_text import exact_text
    from martensite.simulate.drive_waveforms import by_name

    before = target.name.removesuffix("peak")
    held = _find_waveform(scenario, before).get("values")
    if isinstance(held, list):
        values = [units.parse_quantity(v, target.unit) if isinstance(v, str) else float(v) for v in held]
        return {f"{before}waveform.values": [exact_text(factor * v, target.unit) for v in values]}
    level = target.level
    drive = "" if level is None else level.drive
    wave = by_name(scenario.system, scenario.waveform)[drive]
    return {
        f"{before}waveform.{leaf.path}": exact_text(factor * leaf.value, target.unit)
        for leaf in wave.leaves()
        if leaf.declared.unit == "drive"
    }


def _find_waveform(scenario: Scenario, before: str) -> dict[str, Any]:
    """The table of a waveform in the scenario; empty if there is none."""
    node: Any = tomllib.loads(scenario.text)
    for key in f"{before}waveform".split("."):
        node = node.get(key, {}) if isinstance(node, dict) else {}
    return node if isinstance(node, dict) else {}
