"""Ranges of the numbers that a host may set on a board: calibration, references, and declared gains.

All other numbers of a firmware are constants. A board refuses a value outside its range.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from martensite.base import units
from martensite.base.errors import InputError, UnitError, suggest_name
from martensite.boards.firmware.channels import ROOM, Channel
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import list_previews, list_references
from martensite.control.loop.run import reference_waveforms
from martensite.signals.base import DRIVE

if TYPE_CHECKING:
    from martensite.export.c_core import CCore, CoreVariable

Range = tuple[float, float]
"""Lowest and highest value in SI."""
KNOWN_PARTS, SENSOR = 2.0, 10.0
"""Largest factor between nominal and calibrated gain: of dividers and shunts, and of sensors."""
ZERO = 0.1
"""Largest offset of a divider or an amplifier, over the steps of the converter."""
COUNTS = 1e6
"""Largest offset of an encoder [counts]."""
SAMPLED = 2000
"""Number of samples of a reference."""
PLAIN = ("1", DRIVE, "of the reading")
"""Units of plain numbers."""


def find_gain_range(channel: Channel) -> Range:
    """Return the range of the gain of a channel; a sensor may also fall with its quantity."""
    if is_sensor(channel):
        return -SENSOR * channel.gain, SENSOR * channel.gain
    return channel.gain / KNOWN_PARTS, channel.gain * KNOWN_PARTS


def find_offset_range(channel: Channel, steps: int) -> Range:
    """Return the range of the offset of a channel on a converter with a number of steps."""
    if channel.pin < 0:
        return -COUNTS, COUNTS
    room = SENSOR * steps if is_sensor(channel) else ZERO * steps
    return -room, room


def is_sensor(channel: Channel) -> bool:
    """Return whether a channel is a sensor of the user, and not a voltage or current of the wiring list."""
    return not channel.name.startswith(("voltage", "current", "supply"))


def find_input_ranges(bench: Bench, names: Sequence[str], duration: float) -> dict[str, Range]:
    """Return the ranges of references and free signals.

    A reference stays between its extremes in the scenario, 0 included, with `ROOM` of the span above. Signals by hand
    and free signals are between 0 and 1.
    """
    references = {*list_references(bench), *(one.name for one in list_previews(bench))}
    waveforms, times = reference_waveforms(bench), np.linspace(0.0, duration, SAMPLED)
    ranges: dict[str, Range] = {}
    for name in names:
        levels = [waveforms[name].value(float(t)) for t in times] if name in references else []
        low, high = min([0.0, *levels]), max([0.0, *levels])
        ranges[name] = (low, high + ROOM * (high - low)) if levels else (0.0, 1.0)
    return ranges


def list_tunable(core: CCore) -> dict[str, CoreVariable]:
    """Return the parameters of a loop that may be declared tunable: those of controllers, without their limits."""
    ends = (".low", ".high")
    return {
        one.name: one for one in core.parameters if one.name.startswith("controllers.") and not one.name.endswith(ends)
    }


def read_ranges(texts: Sequence[str]) -> dict[str, str]:
    """Return the texts of ranges by name, from `NAME=LOW:HIGH`.

    Raises:
        InputError: a text has another form.
    """
    ranges: dict[str, str] = {}
    for text in texts:
        name, sign, rest = text.partition("=")
        if not sign or ":" not in rest:
            raise InputError(f"Write a range as NAME=LOW:HIGH, such as `reference=0 mm:5 mm`, not `{text}`.")
        ranges[name.strip()] = rest
    return ranges


def parse_range(name: str, text: str, unit: str) -> Range:
    """Return a range `LOW:HIGH` in SI; a gain has no unit.

    Raises:
        InputError: an end is no finite quantity of the unit, or the ends are in the wrong order.
    """
    first, _, last = text.partition(":")
    low, high = (_parse_end(name, one.strip(), unit) for one in (first, last))
    if not low <= high:
        raise InputError(f"The range of `{name}` must rise, but is {text}.")
    return low, high


def _parse_end(name: str, text: str, unit: str) -> float:
    try:
        value = float(text) if unit in PLAIN else units.parse_quantity(text, unit)
    except (ValueError, UnitError) as error:
        raise InputError(f"The range of `{name}` [{unit}] has the end `{text}`: {error}") from None
    if not math.isfinite(value):
        raise InputError(f"The range of `{name}` must have finite ends, but one is {text}.")
    return value


def choose_tuned(core: CCore, texts: Mapping[str, str], inputs: Sequence[str]) -> dict[str, Range]:
    """Return the ranges of the gains that are declared tunable.

    Args:
        core: the loop.
        texts: declared ranges by name, of gains and of inputs.
        inputs: names of the settings that are inputs of the loop.

    Raises:
        InputError: a name is unknown or stands for a limit, or the value of the scenario is outside its range.
    """
    allowed, tuned = list_tunable(core), dict[str, Range]()
    for name, text in texts.items():
        if name in inputs:
            continue
        if name not in allowed:
            raise InputError(
                f"`{name}` is no reference and no gain of a controller, so the host cannot set it. "
                f"{suggest_name(name, [*inputs, *allowed])}"
            )
        low, high = parse_range(name, text, allowed[name].unit)
        if not low <= allowed[name].default <= high:
            raise InputError(f"`{name}` is {allowed[name].default:g} in the scenario, outside its range {text}.")
        tuned[name] = low, high
    return tuned
