"""Axes of a sweep: free parameters (`martensite.search.free_text`) with levels or quantiles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from martensite.base.errors import ParameterError
from martensite.search.free_numbers import FreeNumber, SearchRange, Target, find_alike
from martensite.search.free_text import FORMS, parse_free

MOST_LEVELS = 10_000_000


def parse_axis(words: str, targets: Mapping[str, Target]) -> FreeNumber:
    """Return the axis of a text of `--over`.

    Args:
        words: text of a free parameter with values; the name may be a unique ending.
        targets: variable parameters by name.

    Raises:
        ParameterError: the text is malformed, or the name is unknown.
        UnitError: a value has no unit, or a wrong one.
    """
    text = parse_free(words, *FORMS, complete=True)
    (target,) = find_alike(text.name, [*targets.values()], several=False)
    wanted = SearchRange.read(replace(text, name=target.name), target.unit)
    if wanted.spread:
        return _build_normal(wanted, target)
    if not wanted.choices:
        _require_range(words, wanted)
    return _build(wanted, target)


def _build(wanted: SearchRange, target: Target) -> FreeNumber:
    free_number = FreeNumber(target.name, target.path, target.unit, target.value, *wanted.ends, wanted.scale == "log")
    return replace(free_number, doc=target.doc, targets=(target,), choices=wanted.choices, count=wanted.count)


def _build_normal(wanted: SearchRange, target: Target) -> FreeNumber:
    centre = target.value if wanted.start is None else wanted.start
    spread = wanted.spread * abs(centre) if wanted.relative else wanted.spread
    if not spread > 0.0:
        raise ParameterError(f"A spread in % of `{target.name}` needs a centre other than 0.")
    return replace(_build(wanted, target), start=centre, spread=spread)


def _require_range(words: str, wanted: SearchRange) -> None:
    low, high = wanted.ends
    if not low < high:
        raise ParameterError(f"Axis `{wanted.name}` must rise, but is `{words}`.")
    if wanted.scale == "whole":
        raise ParameterError(
            f"Axis `{wanted.name}` cannot be `whole`; list its levels, such as `{wanted.name}=2, 3, 4`."
        )
    if wanted.scale == "log" and low <= 0.0:
        raise ParameterError(f"A logarithmic axis must be above 0, but `{words}` is not.")
    if wanted.count is not None and not 2 <= wanted.count <= MOST_LEVELS:
        raise ParameterError(f"Axis `{wanted.name}` must have 2 levels or more, not {wanted.count}.")
