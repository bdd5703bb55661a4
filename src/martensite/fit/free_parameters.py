"""Free parameters of a fit, common to all records or separate for each record.

Texts follow `martensite.search.free_text`. A name may match several paths, which then move together, as the material
of several wires does. Further parameters of a record:

    offset.OUTPUT   constant added to the output of the model, in the unit of the output
    delay           delay of the record behind the run [s]

Any parameter of the system, such as `initial_fraction`, may be separate for each record or group (`h:by=specimen`).
A spread makes it a random effect about a centre: the value of the scenario, or the common value if that is also free.
A spread in % is log-normal, any other spread normal.

`A_f-A_s` is the distance of A_f above A_s. If both are free, A_s first, every search keeps their order.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.mechanisms.base import Output
from martensite.base import units
from martensite.base.errors import ParameterError, require_known
from martensite.base.formats import write_quantity
from martensite.fit.experiment import Experiment
from martensite.search.free_numbers import (
    BOX_FACTOR,
    FreeNumber,
    SearchRange,
    Target,
    build_free,
    make_missing_error,
    read_difference,
)
from martensite.search.free_text import FreeText, parse_free

FIT_FORMS = ("range", "spread")
"""Forms of the text of a free parameter in a fit."""
OFFSET, DELAY = "offset", "delay"
"""Parameters of a single record: offset of a sensor, delay of its clock."""
LONGEST_DELAY = 0.05
"""Longest delay in both directions, as a fraction of the record."""
LARGEST_OFFSET = 2.0
"""Largest offset in both directions, in measured ranges."""
SPREADS = 5.0
"""Search range about the centre of a parameter with a spread, in spreads."""


def split_list(texts: str | Sequence[str]) -> list[str]:
    """Return the entries of a list that may be written with commas."""
    given = [texts] if isinstance(texts, str) else texts
    return [part.strip() for text in given for part in text.split(",") if part.strip()]


def read_ranges(
    texts: Iterable[str | FreeText | SearchRange],
    systems: Sequence[AbstractSystem],
    own: bool = False,
    outputs: Mapping[str, Output] | None = None,
) -> list[SearchRange]:
    """Return the requested free parameters.

    Args:
        texts: one text per parameter.
        systems: systems with these parameters.
        own: True for separate values per record, which permits offsets, delays, groups and spreads.
        outputs: outputs that may have an offset, by default the outputs of the first system.

    Raises:
        InputError: a text cannot be read, or its name matches no parameter.
    """
    given = [texts] if isinstance(texts, (str, SearchRange)) else texts
    offset_outputs = systems[0].outputs() if outputs is None else outputs
    return [x if isinstance(x, SearchRange) else _read_range(x, systems, own, offset_outputs) for x in given]


def _read_range(
    text: str | FreeText, systems: Sequence[AbstractSystem], own: bool, outputs: Mapping[str, Output]
) -> SearchRange:
    words = parse_free(text, *FIT_FORMS) if isinstance(text, str) else text
    name = words.name
    if (is_nuisance(name) or words.by or words.form == "spread") and not own:
        raise ParameterError(f"`{name}` belongs to a record, not to the system: ask for it under `each` (--each).")
    if not words.form and words.start is None:
        return SearchRange.read(words, "1")
    if is_nuisance(name):
        if words.form == "spread" and str(words.values[1]).endswith("%"):
            raise ParameterError(f"The spread of `{name}` must have its unit; it is an offset or a delay.")
        unit = _find_own_unit(name, outputs)
    else:
        unit = build_free_numbers([SearchRange(name.partition("-")[0])], systems)[0].unit
    apart = is_nuisance(name) or is_difference(name)
    return SearchRange.read(words, unit, (lambda quantity: read_difference(quantity, unit)) if apart else None)


def _find_own_unit(name: str, outputs: Mapping[str, Output]) -> str:
    if name == DELAY:
        return "s"
    output = name.removeprefix(OFFSET).removeprefix(".")
    if not output:
        raise ParameterError("Bounds of `offset` need the output they are for, such as `offset.strain=-0.1..0.1 %`.")
    require_known("output", output, outputs)
    return outputs[output].unit


def is_difference(name: str) -> bool:
    """Return whether a parameter is a difference, such as `A_f-A_s`."""
    return "-" in name and not is_nuisance(name)


def is_nuisance(path: str) -> bool:
    """Return whether a parameter belongs to the record and not to the system."""
    return path == DELAY or path.partition(".")[0] == OFFSET


def build_free_numbers(
    ranges: Sequence[SearchRange], systems: Sequence[AbstractSystem], record: str | None = None
) -> list[FreeNumber]:
    """Return the free parameters of systems.

    Args:
        ranges: names with optional bounds and starts.
        systems: systems with these parameters. The first system gives the start.
        record: experiment to which these parameters belong.

    Raises:
        ParameterError: an unknown name, invalid bounds, or a start outside of the bounds.
    """
    targets = [Target.from_leaf(leaf) for system in systems for leaf in system.leaves()]
    return [
        _build_difference(wanted, targets, record)
        if is_difference(wanted.name)
        else _build_one(wanted, targets, record)
        for wanted in ranges
    ]


def _build_difference(wanted: SearchRange, all_targets: Sequence[Target], record: str | None) -> FreeNumber:
    """Return a parameter that is a difference from another parameter of the same unit."""
    name, _, base = wanted.name.partition("-")
    one, other = (_build_one(SearchRange(part), all_targets, record) for part in (name, base))
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
    full_name = wanted.name if record is None else f"{wanted.name}@{record}"
    doc = f"how far {name} lies above {base}"
    return FreeNumber(
        full_name, one.path, _unshift(one.unit), start, low, high, record=record, doc=doc, base=other.path
    )


def _unshift(unit: str) -> str:
    """Return the unit of a difference, without the zero shift of temperatures."""
    return units.DEGREES if unit == "K" else unit


def _build_one(wanted: SearchRange, all_targets: Sequence[Target], record: str | None) -> FreeNumber:
    name = wanted.name
    targets = [x for x in all_targets if x.path == name or x.path.endswith("." + name)]
    if not targets:
        raise make_missing_error(name, all_targets)
    if wanted.spread:
        wanted = _widen_range(wanted, targets[0])
    free = build_free(wanted, targets, name if record is None else f"{name}@{record}", record)
    if not free.low <= free.start <= free.high:
        ends = (free.start, free.low, free.high)
        start, low, high = (write_quantity(end, free.unit) for end in ends)
        raise ParameterError(
            f"The fit starts with `{name}` = {start}, outside of its bounds {low} to {high}; move "
            "the bounds or the start."
        )
    return replace(free, targets=(), spread=wanted.spread, relative=wanted.relative)


def _widen_range(wanted: SearchRange, target: Target) -> SearchRange:
    """Return a range of several spreads on both sides of the centre, on the scale of the normal distribution."""
    centre, (least, most) = target.value if wanted.start is None else wanted.start, target.bounds
    if wanted.relative:
        if not centre > 0.0:
            raise ParameterError(f"A spread of `{wanted.name}` in % needs a number above 0; give it in its unit.")
        factor = math.exp(SPREADS * wanted.spread)
        low, high = centre / factor, centre * factor
    else:
        low, high = centre - SPREADS * wanted.spread, centre + SPREADS * wanted.spread
    return replace(wanted, low=max(low, least), high=min(high, most), scale="log" if wanted.relative else None)


def build_own_parameters(ranges: Sequence[SearchRange], experiments: Sequence[Experiment]) -> list[FreeNumber]:
    """Return the separate free parameters of every experiment.

    `offset` alone represents all compared outputs.

    Raises:
        ParameterError: an unknown name, or invalid bounds.
        UnknownNameError: an offset of an output that is not compared.
    """
    parameters: list[FreeNumber] = []
    for wanted in ranges:
        done = set[str]()
        for experiment in experiments:
            label = _find_label(wanted, experiment)
            if label not in done:
                parameters += _list_own(wanted, experiment, label)
            done.add(label)
    return parameters


def _find_label(wanted: SearchRange, experiment: Experiment) -> str:
    """Return the record or group of a separate parameter."""
    if not wanted.by:
        return experiment.name
    if wanted.by not in experiment.groups:
        group_list = ", ".join(f"`{one}`" for one in experiment.groups) or "none"
        raise ParameterError(f"Record `{experiment.name}` belongs to no `{wanted.by}`; its groups are: {group_list}.")
    return experiment.groups[wanted.by]


def _list_own(wanted: SearchRange, experiment: Experiment, record: str) -> list[FreeNumber]:
    name = wanted.name
    if name == DELAY:
        latest = LONGEST_DELAY * float(experiment.times[-1] - experiment.times[0])
        return [_build_own(wanted, DELAY, "s", latest, record, "delay of the record")]
    head, _, output = name.partition(".")
    if head != OFFSET:
        return build_free_numbers([wanted], [experiment.system], record)
    outputs = [output] if output else list(experiment.outputs)
    return [_build_offset(wanted, one, experiment, record) for one in outputs]


def _build_offset(wanted: SearchRange, output: str, experiment: Experiment, record: str) -> FreeNumber:
    require_known("compared output", output, experiment.outputs)
    column = experiment.measured[:, experiment.outputs.index(output)]
    reach = LARGEST_OFFSET * float(np.nanmax(column) - np.nanmin(column))
    unit = _unshift(experiment.describe_outputs()[output].unit)
    return _build_own(wanted, f"{OFFSET}.{output}", unit, reach, record, f"zero of {output}")


def _build_own(wanted: SearchRange, path: str, unit: str, reach: float, record: str, doc: str) -> FreeNumber:
    low = -reach if wanted.low is None else wanted.low
    high = reach if wanted.high is None else wanted.high
    start = min(max(0.0, low), high) if wanted.start is None else wanted.start
    spread = {"spread": wanted.spread, "relative": wanted.relative}
    return FreeNumber(f"{path}@{record}", path, unit, start, low, high, record=record, doc=doc, **spread)


def delay_model(times: Any, model: Any, slopes: Any, delay: float, slope: float, place: int) -> tuple[Any, Any]:
    """Return the outputs delayed by `delay` [s], and their derivatives."""
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
    """Interpolate columns by cubic Hermite pieces, with exact derivatives."""
    spline_type = import_module("scipy.interpolate").CubicHermiteSpline
    return spline_type(times, rows, np.gradient(rows, times, axis=0))
