"""Free parameters of a fit: common to all records, or of each record for itself.

Texts are those of `martensite.search.free_numbers`. A name may end several paths: they then move
together, as one material of several wires does.

What a record has for itself: the zero of a sensor, the delay of its clock.

    offset.OUTPUT   added to what the model says, in the unit of the output
    delay           seconds by which the record lags behind the run

Any parameter of the system may be free for each record as well, such as `initial_fraction`.

`A_f-A_s` is how far A_f lies above A_s. Both may be free, A_s first: then they keep their order wherever a search goes.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base import units
from martensite.base.errors import ParameterError, require_known, suggest_name
from martensite.base.formats import write_quantity
from martensite.fit.experiment import Experiment
from martensite.search.free_numbers import (
    BOX_FACTOR,
    FreeNumber,
    SearchRange,
    Target,
    build_free,
    parse_free,
    read_free,
)

OFFSET, DELAY = "offset", "delay"
"""What a record may have for itself: the zero of a sensor, the delay of its clock."""
LONGEST_DELAY = 0.05
"""Longest delay either way, as a share of the record."""
LARGEST_OFFSET = 2.0
"""Largest offset either way, in measured ranges."""
_AMOUNT = re.compile(r"^\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*(.*?)\s*$")


def split_list(texts: str | Sequence[str]) -> list[str]:
    """Entries of a list that may be written with commas."""
    given = [texts] if isinstance(texts, str) else texts
    return [part.strip() for text in given for part in text.split(",") if part.strip()]


def read_ranges(
    texts: Iterable[str | SearchRange], systems: Sequence[AbstractSystem], own: bool = False
) -> list[SearchRange]:
    """Free parameters as asked for.

    Args:
        texts: one per parameter.
        systems: those that have the parameters.
        own: whether every record has them for itself, so that offsets and delays may be asked for.

    Raises:
        InputError: a text cannot be read, or names no parameter.
    """
    given = [texts] if isinstance(texts, (str, SearchRange)) else texts
    return [x if isinstance(x, SearchRange) else _read_range(x, systems, own) for x in given]


def _read_range(text: str, systems: Sequence[AbstractSystem], own: bool) -> SearchRange:
    name, bounds, start, scale = parse_free(text)
    if is_nuisance(name) and not own:
        raise ParameterError(f"`{name}` belongs to a record, not to the system: ask for it under `each` (--each).")
    if bounds is None and start is None:
        return SearchRange(name, scale=scale)
    if is_nuisance(name) or is_difference(name):
        unit = _find_own_unit(name, systems[0]) if is_nuisance(name) else _find_difference_unit(name, systems)
        return read_free(text, unit, lambda words: read_difference(words, unit))
    unit = build_free_numbers([SearchRange(name)], systems)[0].unit
    return read_free(text, unit, lambda words: units.parse_quantity(words, unit))


def _find_own_unit(name: str, system: AbstractSystem) -> str:
    if name == DELAY:
        return "s"
    output, known = name.removeprefix(OFFSET).removeprefix("."), system.outputs()
    if not output:
        raise ParameterError("Bounds of `offset` need the output they are for, such as `offset.strain=-0.1..0.1 %`.")
    require_known("output", output, known)
    return known[output].unit


def read_difference(text: str, unit: str) -> float:
    """A difference in the SI `unit`, such as 0.5 K for `0.5 degC`.

    Raises:
        UnitError: the text is no number with a unit that fits.
    """
    zero = re.sub(_AMOUNT, lambda found: f"0 {found[2]}", text)
    return units.parse_quantity(text, unit) - units.parse_quantity(zero, unit)


def _find_difference_unit(name: str, systems: Sequence[AbstractSystem]) -> str:
    return build_free_numbers([SearchRange(name.partition("-")[0])], systems)[0].unit


def is_difference(name: str) -> bool:
    """True for a number that is counted from another, `A_f-A_s`."""
    return "-" in name and not is_nuisance(name)


def is_nuisance(path: str) -> bool:
    """True for what belongs to the record and not to the system."""
    return path == DELAY or path.partition(".")[0] == OFFSET


def build_free_numbers(
    ranges: Sequence[SearchRange], systems: Sequence[AbstractSystem], record: str | None = None
) -> list[FreeNumber]:
    """Free parameters of systems.

    Args:
        ranges: names with optional bounds and starts.
        systems: those in which the parameters are looked for; the first gives the start.
        record: the experiment that has these parameters for itself.

    Raises:
        ParameterError: an unknown name, bounds that are none, a start outside of them.
    """
    known = [Target.from_leaf(leaf) for system in systems for leaf in system.leaves()]
    return [
        _build_difference(wanted, known, record) if is_difference(wanted.name) else _build_one(wanted, known, record)
        for wanted in ranges
    ]


def _build_difference(wanted: SearchRange, known: Sequence[Target], record: str | None) -> FreeNumber:
    """A number that is counted from another of the same unit."""
    name, _, base = wanted.name.partition("-")
    one, other = (_build_one(SearchRange(part), known, record) for part in (name, base))
    if one.unit != other.unit:
        raise ParameterError(f"`{wanted.name}` is no difference: one is in {one.unit}, the other in {other.unit}.")
    apart = one.start - other.start
    start = apart if wanted.start is None else wanted.start
    low = min(start / BOX_FACTOR, start * BOX_FACTOR) if wanted.low is None else wanted.low
    high = max(start / BOX_FACTOR, start * BOX_FACTOR) if wanted.high is None else wanted.high
    if not low <= start <= high or low == high:
        raise ParameterError(
            f"The difference `{wanted.name}` starts at {start:g} {one.unit}, outside of its bounds {low:g} to "
            f"{high:g}; move the bounds or the start."
        )
    shown = wanted.name if record is None else f"{wanted.name}@{record}"
    doc = f"how far {name} lies above {base}"
    return FreeNumber(shown, one.path, one.unit, start, low, high, record=record, doc=doc, base=other.path)


def _build_one(wanted: SearchRange, known: Sequence[Target], record: str | None) -> FreeNumber:
    name = wanted.name
    found = [x for x in known if x.path == name or x.path.endswith("." + name)]
    if not found:
        names = list(dict.fromkeys(x.path.rpartition(".")[2] for x in known))
        raise ParameterError(f"There is no parameter `{name}` to be fitted. {suggest_name(name, names)}")
    free = build_free(wanted, found, name if record is None else f"{name}@{record}", record)
    if not free.low <= free.start <= free.high:
        ends = (free.start, free.low, free.high)
        start, low, high = (write_quantity(end, free.unit) for end in ends)
        raise ParameterError(
            f"The fit starts with `{name}` = {start}, outside of its bounds {low} to {high}; move "
            "the bounds or the start."
        )
    return replace(free, targets=())


def build_own_parameters(ranges: Sequence[SearchRange], experiments: Sequence[Experiment]) -> list[FreeNumber]:
    """Free parameters that every experiment has for itself.

    `offset` alone stands for all outputs that are compared.

    Raises:
        ParameterError: an unknown name, or bounds that are none.
        UnknownNameError: an offset of an output that is not compared.
    """
    found: list[FreeNumber] = []
    for wanted in ranges:
        for experiment in experiments:
            found += _list_own(wanted, experiment)
    return found


def _list_own(wanted: SearchRange, experiment: Experiment) -> list[FreeNumber]:
    name, record = wanted.name, experiment.name
    if name == DELAY:
        latest = LONGEST_DELAY * float(experiment.times[-1] - experiment.times[0])
        return [_build_own(wanted, DELAY, "s", latest, record, "delay of the record")]
    head, _, output = name.partition(".")
    if head != OFFSET:
        return build_free_numbers([wanted], [experiment.system], record)
    outputs = [output] if output else list(experiment.outputs)
    return [_build_offset(wanted, one, experiment) for one in outputs]


def _build_offset(wanted: SearchRange, output: str, experiment: Experiment) -> FreeNumber:
    require_known("compared output", output, experiment.outputs)
    column = experiment.measured[:, experiment.outputs.index(output)]
    reach = LARGEST_OFFSET * float(np.nanmax(column) - np.nanmin(column))
    unit = experiment.system.outputs()[output].unit
    return _build_own(wanted, f"{OFFSET}.{output}", unit, reach, experiment.name, f"zero of {output}")


def _build_own(wanted: SearchRange, path: str, unit: str, reach: float, record: str, doc: str) -> FreeNumber:
    low = -reach if wanted.low is None else wanted.low
    high = reach if wanted.high is None else wanted.high
    start = min(max(0.0, low), high) if wanted.start is None else wanted.start
    return FreeNumber(f"{path}@{record}", path, unit, start, low, high, record=record, doc=doc)


def delay_model(times: Any, model: Any, slopes: Any, delay: float, slope: float, place: int) -> tuple[Any, Any]:
    """What is seen `delay` [s] late, and its derivatives."""
    first, last = times[0], times[-1]
    at = np.clip(times - delay, first, last)
    curve = _interpolate_rows(times, model)
    if slopes is not None:
        turned = _interpolate_rows(times, slopes)(at)
        inside = (at > first) & (at < last)
        turned[:, :, place] -= slope * np.where(inside[:, None], curve(at, 1), 0.0)
        slopes = turned
    return curve(at), slopes


def _interpolate_rows(times: Any, rows: Any) -> Any:
    """Smooth columns through rows: cubic Hermite pieces, so that their slopes are exact."""
    made = import_module("scipy.interpolate").CubicHermiteSpline
    return made(times, rows, np.gradient(rows, times, axis=0))
