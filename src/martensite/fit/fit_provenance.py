"""Provenance of a fit as a table: records, bounds, errors, independent of time and place."""

from __future__ import annotations

import hashlib
from array import array
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from martensite.base.confidence import EVERYTHING, Interval
from martensite.fit.fit import HELD_OUT, TRAINING, ComparedOutput, Fit, list_compared
from martensite.fit.fit_verdicts import format_error
from martensite.logs.datasets import dataset_names, describe_dataset
from martensite.scenario.exact_text import exact_text, format_quantity, shown_range
from martensite.search.free_numbers import FreeNumber
from martensite.signals.records import Record

PACKAGE = "martensite"
NOT_DETERMINED = "not determined by the data"


def describe_program() -> str:
    """Return the name of this package with its version."""
    try:
        return f"{PACKAGE} {version(PACKAGE)}"
    except PackageNotFoundError:  # run from a source tree without installation
        return PACKAGE


def compute_digest(record: Record) -> dict[str, str]:
    """Return the SHA-256 of the file of a record, or of its columns for a record without a file.

    Returns:
        `{"file": name, "sha256": …}`, or `{"sha256_of_columns": …}` over the name of each column and its values as
        little-endian doubles, in the order of the record.
    """
    if record.source is not None and record.source.is_file():
        digest = hashlib.sha256(record.source.read_bytes()).hexdigest()
        return {"file": record.source.name, "sha256": digest}
    total = hashlib.sha256()
    for name, column in record.columns.items():
        numbers = array("d", column)
        if array("H", [1]).tobytes() != b"\1\0":
            numbers.byteswap()
        total.update(name.encode() + b"\0" + numbers.tobytes())
    return {"sha256_of_columns": total.hexdigest()}


def list_published(fit: Fit) -> list[str]:
    """Return the bibliography keys of the published data sets of a fit."""
    published_names = dataset_names()
    sets = (one.experiment.record.name.partition("/")[0] for one in list_compared(fit))
    return list(dict.fromkeys(describe_dataset(name).cite for name in sets if name in published_names))


def build_provenance(fit: Fit) -> dict[str, Any]:
    """Return the whole table: search, free parameters, and fitted records."""
    return {
        "by": describe_program(),
        "method": fit.method,
        "loss": fit.loss,
        "ended": fit.reason,
        "cost": fit.cost,
        "simulations": fit.simulations,
        "jacobians": fit.jacobians,
        "free": {free.name: _describe_free(fit, free) for free in fit.problem.free},
        "records": list(_describe_records(fit)),
    }


def format_interval(interval: Interval, unit: str) -> str:
    """Return an interval such as `62.5 to 63.9 degC`, or its absence."""
    return NOT_DETERMINED if interval == EVERYTHING else shown_range(interval, unit)


def _describe_free(fit: Fit, free: FreeNumber) -> dict[str, Any]:
    entries: dict[str, Any] = {
        "value": exact_text(fit[free.name], free.unit),
        "interval": format_interval(fit.uncertainty.interval(free.name), free.unit),
        "widened": format_interval(fit.uncertainty.widen_interval(free.name), free.unit),
        "start": format_quantity(free.start, free.unit),
        "low": format_quantity(free.low, free.unit),
        "high": format_quantity(free.high, free.unit),
    }
    return entries | ({"at_bound": True} if free.name in fit.at_bound() else {})


def _describe_records(fit: Fit) -> Iterator[dict[str, Any]]:
    rows = list_compared(fit)
    own = {held_out_record.experiment.name: held_out_record for held_out_record in fit.held_out_records}
    for name in dict.fromkeys(one.record for one in rows):
        outputs = [one for one in rows if one.record == name]
        record = outputs[0].experiment.record
        entries: dict[str, Any] = {"name": name, **compute_digest(record), "rows": len(outputs[0].times)}
        if record.dropped:
            entries["rows_left_out_on_reading"] = record.dropped
        entries["outputs"] = {one.output: _describe_output(one) for one in outputs}
        if name in own and own[name].numbers:
            entries["fitted_to_it_alone"] = dict(own[name].numbers)
        yield entries


def _describe_output(one: ComparedOutput) -> dict[str, Any]:
    entries: dict[str, Any] = {"column": one.column}
    for part, rows in ((TRAINING, one.training_rows), (HELD_OUT, one.held_out_rows)):
        if rows.any():
            key, unit = part.replace("-", "_"), one.description.unit
            entries[f"{key}_rows"] = int(rows.sum())
            entries[f"{key}_rms"] = format_error(one.output, one.rms(part), unit)
    return entries | ({"missing": one.missing} if one.missing else {})
