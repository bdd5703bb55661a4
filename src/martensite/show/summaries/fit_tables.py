"""The tables of a fit: records, parameters, errors, and all digits."""

from __future__ import annotations

import math

from martensite.base import units
from martensite.base.confidence import Interval
from martensite.base.formats import choose_difference_unit, typeset_unit
from martensite.base.summary import DataTable
from martensite.fit.fit import HELD_OUT, ComparedOutput, Fit, list_compared
from martensite.fit.fit_provenance import compute_digest
from martensite.fit.fit_verdicts import format_error
from martensite.fit.free_parameters import is_nuisance
from martensite.scenario.exact_text import format_quantity
from martensite.search.free_numbers import FreeNumber
from martensite.search.model_score import Score

DIGITS = 4
"""Digits of a value without an error."""
TAG = "held out"


def tabulate_records(fit: Fit) -> DataTable:
    """Return a table of records with their data and numbers of rows."""
    rows = list_compared(fit)
    return DataTable(
        ("record", "data", "compared", "rows", "fitted", "held out", "missing"),
        [_write_record(one) for one in rows],
        right=(3, 4, 5, 6),
        note="The hash is the SHA-256 of the file, or of the columns where there is no file. Rows "
        "are those that were compared: long records are thinned evenly.",
        tags={k: TAG for k, one in enumerate(rows) if one.held_out_rows.any() and not one.training_rows.any()},
    )


def _write_record(one: ComparedOutput) -> tuple[str, ...]:
    record = one.experiment.record
    digest = compute_digest(record)
    name = f"`{digest['file']}` " if "file" in digest else "columns "
    data = name + f"`{digest.get('sha256') or digest['sha256_of_columns']}`"
    if record.dropped:
        data += f" ({record.dropped} rows dropped on reading)"
    what = f"`{one.output}`" + (f" with `{one.column}`" if one.column != one.output else "")
    counts = (len(one.times), int(one.training_rows.sum()), int(one.held_out_rows.sum()), one.missing)
    return one.record, data, what, *map(str, counts)


def tabulate_parameters(fit: Fit) -> DataTable:
    """Return a table of the fitted parameters, their intervals, and their search ranges."""
    return DataTable(
        (
            "parameter",
            "value",
            "unit",
            "95 % interval",
            "if samples were independent",
            "start",
            "bounds",
            "remark",
            "meaning",
        ),
        [_write_parameter(fit, free) for free in fit.problem.free],
        right=(1,),
        detail=(4, 8),
        note="The first interval is widened for the autocorrelation of the residuals, the second "
        "is not. Both hold for this model and are linear about the optimum.",
        tones={"not determined": "caution", "weak": "caution", "at a bound": "caution"},
    )


def _write_parameter(fit: Fit, free: FreeNumber) -> tuple[str, ...]:
    uncertainty, value = fit.uncertainty, fit[free.name]
    spelling = choose_parameter_unit(free, value)
    plain, wide = uncertainty.interval(free.name), uncertainty.widen_interval(free.name)
    decimals = _choose_decimals(plain, free.unit, spelling)
    start, *bounds = (_write_number(end, free.unit, spelling, None) for end in (free.start, free.low, free.high))
    return (
        f"`{free.name}`",
        _write_number(value, free.unit, spelling, decimals),
        typeset_unit(spelling),
        _write_interval(wide, free.unit, spelling, decimals),
        _write_interval(plain, free.unit, spelling, decimals),
        start,
        " to ".join(bounds),
        mark_parameter(fit, free.name),
        free.doc,
    )


def choose_parameter_unit(free: FreeNumber, value: float) -> str:
    """Return the displayed unit of a parameter; an offset is a difference."""
    if is_nuisance(free.path):
        return choose_difference_unit(free.unit)[0]
    return units.choose_familiar_unit(value, free.unit)


def mark_parameter(fit: Fit, name: str) -> str:
    """Return a short caution about a parameter; empty without one."""
    if not all(map(math.isfinite, fit.uncertainty.widen_interval(name))):
        return "not determined"
    if name in fit.at_bound():
        return "at a bound"
    if any(name in one.names for one in fit.identifiability.weak):
        return "weak"
    return "not determined" if name in fit.undetermined else ""


def _choose_decimals(interval: Interval, unit: str, spelling: str) -> int | None:
    half = 0.5 * (interval[1] - interval[0]) / units.find_conversion(spelling, unit)[0]
    if not 0.0 < half < math.inf:
        return None
    return max(0, 1 - math.floor(math.log10(half)))


def _write_number(value: float, unit: str, spelling: str, decimals: int | None) -> str:
    read = units.from_si(value, spelling, unit)
    if decimals is None or decimals > 9:
        return f"{float(f'{read:.{DIGITS}g}'):.{DIGITS}g}"
    return f"{read:.{decimals}f}"


def _write_interval(ends: Interval, unit: str, spelling: str, decimals: int | None) -> str:
    if not math.isfinite(ends[1] - ends[0]):
        return "not determined"
    return " to ".join(_write_number(end, unit, spelling, decimals) for end in ends)


def tabulate_own_numbers(fit: Fit) -> DataTable | None:
    """Return a table of the parameters fitted to held-out records alone; None without such parameters."""
    table = {free.path: free for free in fit.problem.free}
    rows = list[tuple[str, ...]]()
    for held_out_record in fit.held_out_records:
        for name, value in held_out_record.numbers.items():
            free = table.get(name.rpartition("@")[0])
            text = f"{value:.6g}" if free is None else format_quantity(value, free.unit)
            rows.append((f"`{name}`", text, free.doc if free else ""))
    note = "Fitted to the held-out log, with all other parameters fixed."
    tags = dict.fromkeys(range(len(rows)), TAG)
    head = ("parameter", "value", "meaning")
    return DataTable(head, rows, right=(1,), note=note, tags=tags) if rows else None


def tabulate_errors(fit: Fit) -> DataTable:
    """Return a table of the errors of every record, with held-out records marked."""
    rows = [(one, score) for one in list_compared(fit) for score in one.score()]
    raw = any(one.raw is not None for one, _ in rows)
    note = "A fit of 100 % is perfect; 0 % is no better than the mean of the log. Bias is modelled minus measured."
    if raw:
        note += " Errors of a held-out log include the offset or delay that was fitted to it; raw errors do not."
    return DataTable(
        (
            "record",
            "output",
            "rms error",
            *(("raw rms error",) if raw else ()),
            "fit",
            "max. error",
            "at",
            "bias",
            "rows",
        ),
        [_write_error(score, one.raw_rms if raw else None) for one, score in rows],
        right=tuple(range(2, 9 if raw else 8)),
        note=note,
        tags={k: TAG for k, (_, score) in enumerate(rows) if score.part == HELD_OUT},
    )


def _write_error(score: Score, raw: float | None) -> tuple[str, ...]:
    fit = "–" if math.isnan(score.fit_percent) else f"{score.fit_percent:.1f} %"
    rms, largest = (format_error(score.output, v, score.unit) for v in (score.rms, score.maximum))
    bias = format_error(score.output, 0.0 if abs(score.bias) < 1e-6 * score.rms else score.bias, score.unit)
    bare = () if raw is None else ("" if math.isnan(raw) else format_error(score.output, raw, score.unit),)
    return score.record, f"`{score.output}`", rms, *bare, fit, largest, score.where, bias, str(score.samples)


def tabulate_all_digits(fit: Fit) -> DataTable:
    """Return all free parameters in SI with all digits."""
    return DataTable(
        ("parameter", "value", "standard error", "SI unit"),
        [
            (f"`{free.name}`", f"{fit[free.name]!r}", f"{error:.6g}", f"`{free.unit}`")
            for free, error in zip(fit.problem.free, fit.uncertainty.errors, strict=True)
        ],
        right=(1, 2),
        note="Standard errors are those for independent samples.",
        folded="All digits, in SI",
    )
