"""Resampling, splitting and grouping of records.

A longer sample time averages inputs and outputs over the new interval. Averaging commutes with every linear system and
avoids aliasing. For a shorter sample time, inputs are held and outputs interpolated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from martensite.base.errors import DataError, suggest_name
from martensite.signals.sampling.sampled import Numbers, Sampled

COUNT_TOLERANCE = 1e-9
"""Relative rounding of sample counts."""


def resample_record(record: Sampled, interval: float | None = None, *, ratio: float | None = None) -> Sampled:
    """Return the record at another sample time.

    Args:
        record: record to resample.
        interval: new sample time [s].
        ratio: new sample time over the old one, instead of `interval`.

    Raises:
        DataError: not exactly one of the two is given, it is not above 0, or the record is too short.
    """
    if (interval is None) == (ratio is None):
        raise DataError("Resampling needs either `interval` or `ratio`.")
    factor = interval / record.interval if interval is not None else ratio or 0.0
    if not 0.0 < factor < np.inf:
        raise DataError(f"The ratio of resampling must be above 0, but is {factor:g}.")
    if abs(factor - 1.0) < COUNT_TOLERANCE:
        return record
    inputs, outputs = (_average_samples if factor > 1.0 else _refine_samples)(record, factor)
    if not len(inputs):
        raise DataError(
            f"Record `{record.name}` of {record.duration:.6g} s is shorter than one sample of "
            f"{factor * record.interval:.6g} s."
        )
    return replace(record, interval=factor * record.interval, inputs=inputs, outputs=outputs)


def _average_samples(record: Sampled, factor: float) -> tuple[Numbers, Numbers]:
    """Return the means over new samples; NaN if less than half of a sample is known."""
    edges = factor * np.arange(int(len(record) / factor * (1.0 + COUNT_TOLERANCE)) + 1)
    finite = np.isfinite(record.outputs)
    shares = _average_held(finite.astype(float), edges)
    sums = _average_held(np.where(finite, record.outputs, 0.0), edges)
    enough = shares >= 0.5
    outputs = np.where(enough, sums / np.where(enough, shares, 1.0), np.nan)
    return _average_held(record.inputs, edges), outputs


def _average_held(values: Numbers, edges: Numbers) -> Numbers:
    """Return the means of sample-and-hold columns between edges, in units of samples."""
    if not len(values) or len(edges) < 2:
        return np.empty((0, values.shape[1]))
    first = values[0]
    sums = np.vstack([np.zeros_like(first), np.cumsum(values - first, axis=0)])
    places = np.arange(len(sums))
    columns: list[Numbers] = [np.interp(edges, places, column) for column in sums.T]
    return first + np.diff(np.stack(columns, axis=1), axis=0) / np.diff(edges)[:, None]


def _refine_samples(record: Sampled, factor: float) -> tuple[Numbers, Numbers]:
    count = int((len(record) - 1) / factor * (1.0 + COUNT_TOLERANCE)) + 1
    places = np.minimum(factor * np.arange(count), len(record) - 1)
    left = np.floor(places * (1.0 + COUNT_TOLERANCE)).astype(int)
    share = np.maximum(places - left, 0.0)[:, None]
    right = np.minimum(left + 1, len(record) - 1)
    exact = share < COUNT_TOLERANCE * len(record)
    between = (1.0 - share) * record.outputs[left] + share * record.outputs[right]
    return record.inputs[left], np.where(exact, record.outputs[left], between)


def split_record(record: Sampled, *, share: float | None = None, time: float | None = None) -> tuple[Sampled, Sampled]:
    """Return the record before and after a moment, as two records.

    Args:
        record: record to split.
        share: fraction of the samples before the split.
        time: time of the split [s], instead of `share`.

    Raises:
        DataError: not exactly one of the two is given, or a part would be empty.
    """
    if (share is None) == (time is None):
        raise DataError("Split a record either at a `share` or at a `time`.")
    place = (share or 0.0) * len(record)
    if time is not None:
        place = (time - record.start) / record.interval
    place = int(np.clip(np.ceil(place - 1e-6), -1, len(record)))
    if not 0 < place < len(record):
        place = f"the share {share:g}" if share is not None else f"{time:g} s"
        raise DataError(
            f"Record `{record.name}` goes from {record.start:.6g} to "
            f"{record.start + record.duration:.6g} s; split at {place}, a part would be empty."
        )
    names = (f"{record.name} (first part)", f"{record.name} (second part)")
    return record.rows(0, place, names[0]), record.rows(place, None, names[1])


def collect_experiments(*records: Sampled) -> tuple[Sampled, ...]:
    """Return consistent records for one estimation, each with a unique name.

    Raises:
        DataError: sample times, signals or units differ.
    """
    if not records:
        raise DataError("Experiments are at least one record, but none is given.")
    first, names = records[0], [record.name for record in records]
    for record in records[1:]:
        fault = _describe_misfit(first, record)
        if fault:
            raise DataError(f"Records `{first.name}` and `{record.name}` cannot be fitted together: {fault}.")
    return tuple(
        replace(r, name=f"{r.name} ({names[: k + 1].count(r.name)})") if names.count(r.name) > 1 else r
        for k, r in enumerate(records)
    )


def _describe_misfit(one: Sampled, other: Sampled) -> str:
    if abs(other.interval / one.interval - 1.0) > 1e-6:
        return f"one is sampled every {one.interval:.6g} s, the other every {other.interval:.6g} s"
    for word in ("input", "output"):
        own, its = getattr(one, f"{word}_names"), getattr(other, f"{word}_names")
        if own != its:
            return f"their {word}s are {_list_names(own)} and {_list_names(its)}"
    names = (*one.input_names, *one.output_names)
    name = next((n for n in names if _find_unit(one, n) != _find_unit(other, n)), None)
    if name is not None:
        return f"`{name}` is in {_find_unit(one, name)} and in {_find_unit(other, name)}"
    return ""


def _find_unit(record: Sampled, name: str) -> str:
    return record.units.get(name, "1")


def _list_names(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def select_signals(record: Sampled, inputs: Sequence[str], outputs: Sequence[str]) -> Sampled:
    """Return the record of some of its signals; an output may become an input.

    Missing samples of such an output are interpolated.

    Raises:
        DataError: the record has no such signal, or the signal is unknown throughout.
    """
    signals = dict(zip(record.output_names, record.outputs.T, strict=True))
    signals |= dict(zip(record.input_names, record.inputs.T, strict=True))
    for name in (*inputs, *outputs):
        if name not in signals:
            raise DataError(f"Record `{record.name}` has no signal `{name}`. {suggest_name(name, signals)}")
    remarks = list(record.remarks)
    columns = [_bridge_gaps(record.name, name, signals[name], remarks) for name in inputs]
    return replace(
        record,
        inputs=np.stack(columns, axis=1),
        outputs=np.stack([signals[name] for name in outputs], axis=1),
        input_names=tuple(inputs),
        output_names=tuple(outputs),
        remarks=tuple(remarks),
        units={n: record.units[n] for n in (*inputs, *outputs) if n in record.units},
    )


def _bridge_gaps(record: str, name: str, column: Numbers, remarks: list[str]) -> Numbers:
    finite = np.isfinite(column)
    missing = int(len(column) - finite.sum())
    if not missing:
        return column
    if missing == len(column):
        raise DataError(f"Signal `{name}` of record `{record}` is missing throughout.")
    remarks.append(f"{missing} missing samples of `{name}`, an input here, were interpolated.")
    places = np.arange(len(column))
    return np.interp(places, places[finite], column[finite])
