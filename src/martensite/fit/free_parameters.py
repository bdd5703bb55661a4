"""Free parameters of a fit: common to all records, or of each record for itself.

Texts are those of `martensite.search.free_numbers`. A name may end several paths: they then move
together, as one material of several wires does.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from martensite.actuators.assembly import AbstractSystem
from martensite.base import units
from martensite.base.errors import ParameterError, require_known, suggest_name
from martensite.base.formats import write_quantity
from martensite.search.free_numbers import FreeNumber, SearchRange, Target, build_free, parse_free, read_free

OFFSET, DELAY = "offset", "delay"
"""What a record may have for itself: the zero of a sensor, the delay of its clock."""
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
    if is_nuisance(name):
        unit = _find_own_unit(name, systems[0])
        return read_free(text, unit, lambda words: read_difference(words, unit))
    unit = build_free_numbers([SearchRange(name)], systems)[0].unit
    return read_free(text, unit, lambda words: units.parse_quantity(words, unit))


def _find_own_unit(name: str, system: AbstractSystem) -> str:
    """SI unit of an offset or a delay."""
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
    return [_build_one(wanted, known, record) for wanted in ranges]


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
