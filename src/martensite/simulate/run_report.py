"""Sentences, table and values that summarise a result, for screens, pages and JSON."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from martensite.base import units
from martensite.base.formats import show_quantity, typeset_unit
from martensite.base.summary import DataTable, Sentence, Summary
from martensite.simulate.provenance import NOT_TRIED

if TYPE_CHECKING:
    from martensite.simulate.result import Result, Variants

ROUNDING = 1e-6
"""Fraction of the larger end of a range below which values are shown as 0."""
HEADINGS = ("quantity", "min", "max", "unit", "column")


def summarise_result(result: Result) -> Summary:
    """Return the ranges of all columns, balances, remarks and warnings of a result, with its values."""
    sentences = [Sentence(one) for one in (result.start, *result.balances(), *_list_remarks(result)) if one]
    warned = [Sentence(one, "caution") for one in result.warnings]
    return Summary("", [tabulate_ranges(result), *sentences, *warned], _collect_values(result), _describe_end(result))


def describe_result(result: Result) -> str:
    """Return a summary of a few lines."""
    alone = result.variants is None
    judged = result.system.convergence_scales() if alone else result.columns
    lines = [_describe_end(result), *(_describe_range(result, name) for name in judged)]
    own = result.balances() if alone else []
    return "\n".join([*lines, *own, *_list_remarks(result), *result.warnings])


def _collect_values(result: Result) -> dict[str, Any]:
    """Return all values except columns, by name in SI; accuracy and stroke of a batch are lists."""
    ends = {name: result.find_range(name) for name in result.outputs}
    accuracy: Any = result.accuracy
    stroke: Any = None
    if result.variants is None:
        stroke = result.stroke
    else:
        accuracy = accuracy if result.variants.accuracy is None else result.variants.accuracy.tolist()
        stroke = result.stroke.tolist() if result.coordinate in result.columns else None
    return {
        "duration": float(result.times[-1]),
        "start": result.start,
        "steps": result.steps,
        "step": result.step,
        "accuracy": accuracy,
        "runtime": result.runtime or None,
        "rejected_steps": result.rejected,
        "ripple": result.ripple,
        "heat": None if result.heat is None else result.heat.as_dict(),
        "work": None if result.work is None else result.work.as_dict(),
        "unbalanced": list(result.unbalanced),
        "conformance": result.conformance,
        "status": result.status.name,
        "status_time": result.status_time,
        "stroke": stroke,
        "columns": {
            name: {"lowest": low, "highest": high, "unit": result.unit(name)} for name, (low, high) in ends.items()
        },
        "warnings": list(result.warnings),
        "alarms": [asdict(alarm) for alarm in result.alarms],
    }


def _describe_end(result: Result) -> str:
    """Return one line with the end, steps and accuracy of the run."""
    if result.variants is not None:
        return _describe_variants(result, result.variants)
    error = "not estimated" if result.accuracy is None else f"at most {result.accuracy:.1e} of each range"
    where = f", runtime {result.runtime}" if result.runtime else ""
    begin = f"{result.times[0]:.6g} s to " if result.times[0] else ""
    steps = f"{result.steps} steps of at most {result.step:.3g} s{where}"
    return f"Run: {begin}{result.times[-1]:.6g} s in {steps}; numerical error: {error}"


def _describe_variants(result: Result, variants: Variants) -> str:
    """Return the endings and accuracy of the runs of a batch."""
    bounds: list[float] = [] if variants.accuracy is None else variants.accuracy.tolist()
    estimates = [one for one in bounds if not math.isnan(one)]
    error = f"at most {max(estimates):.1e} of each range" if estimates else "not estimated"
    return (
        f"{len(variants)} variants of {result.times[-1]:.6g} s over "
        f"{', '.join(variants.over)}: {variants.count_endings()}; numerical error: {error}"
    )


def _list_remarks(result: Result) -> list[str]:
    """Return remarks on user-defined parts, in sentences."""
    remedies = {"conforms": ".", NOT_TRIED: "; run `martensite conform FILE`."}
    return [
        f"Part `{name}` is not from this package; its conformance: {verdict}"
        f"{remedies.get(verdict, '; what it computes cannot be trusted.')}"
        for name, verdict in result.conformance.items()
    ]


def _describe_range(result: Result, name: str) -> str:
    """Return the first and last value of a column in a readable unit."""
    low, high = (show_quantity(end, result.unit(name)) for end in result.find_range(name))
    number, _, unit = low.partition(" ")
    same = unit and high.endswith(f" {unit}")
    return f"{result.outputs[name].long_name} {number if same else low} to {high}"


def tabulate_ranges(result: Result) -> DataTable:
    """Return the lowest and highest value of each output of a run, with its unit and column name.

    Args:
        result: single run, loop or batch.

    Returns:
        A table with one row per output. The highest temperature of an element is left out if it is the temperature.
    """
    names = [name for name in result.outputs if not _repeats_temperature(result, name)]
    return DataTable(HEADINGS, [_write_row(result, name) for name in names], right=(1, 2))


def _write_row(result: Result, name: str) -> tuple[str, ...]:
    unit = result.unit(name)
    readable_unit = units.of_column(name, unit)
    low, high = result.find_range(name)
    zero = ROUNDING * max(abs(low), abs(high))
    ends = (
        show_quantity(0.0 if abs(end) < zero else end, unit, 4, readable_unit).partition(" ")[0] for end in (low, high)
    )
    return (result.outputs[name].long_name, *ends, typeset_unit(readable_unit), name)


def _repeats_temperature(result: Result, name: str) -> bool:
    head, _, last = name.rpartition("hottest")
    other = f"{head}temperature"
    return not last and other in result.outputs and result.find_range(name) == result.find_range(other)
