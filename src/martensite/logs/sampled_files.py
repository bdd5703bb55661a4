"""Logs as records at equal intervals (`Sampled`), from all files that `logs.reader` reads.

`units` gives the unit of columns without one in the file, and of the result. A column `t` of a MAT file is a time, by
default in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from martensite.base.errors import DataError
from martensite.base.files import write_file
from martensite.logs.reader import is_columnar, read_exact, read_one, tell_guesses
from martensite.signals.records import Record
from martensite.signals.sampling.regular_grid import from_record, split_at_gaps
from martensite.signals.sampling.sampled import Sampled


def read_sampled(
    path: str | Path,
    inputs: Sequence[str],
    outputs: Sequence[str],
    interval: float | None = None,
    units: Mapping[str, str] | None = None,
) -> Sampled:
    """Return a log as a record at equal intervals (`signals.sampling.regular_grid`).

    Args:
        path: file, or `data:<data set>/<file>`.
        inputs: input columns.
        outputs: output columns.
        interval: sample time [s], by default as in the rows. For a file without times, the time between rows.
        units: units of columns, such as `{"position": "mm"}`; by default readable units.

    Raises:
        DataError: the file is missing, of unknown kind, malformed, or lacks a column.
        InputError: it is a Parquet file and pyarrow is not installed.
    """
    record = read_columns(path, (*inputs, *outputs), interval, units or {})
    return from_record(record, inputs, outputs, interval, units)


def read_pieces(
    path: str | Path,
    inputs: Sequence[str],
    outputs: Sequence[str],
    interval: float | None = None,
    units: Mapping[str, str] | None = None,
    new_headings: Mapping[str, str] | None = None,
) -> tuple[Sampled, ...]:
    """Return a log as `read_sampled` does, split at gaps of its inputs (`regular_grid.split_at_gaps`)."""
    record = read_columns(path, (*inputs, *outputs), interval, units or {}, new_headings)
    return split_at_gaps(record, inputs, outputs, interval, units)


def read_columns(
    path: str | Path,
    names: Sequence[str],
    interval: float | None,
    units: Mapping[str, str],
    new_headings: Mapping[str, str] | None = None,
) -> Record:
    """Return a log as a table in SI; of files of arrays only the chosen columns, in `units` by default.

    Raises:
        DataError: the file is missing, of unknown kind, malformed, or lacks a column.
        InputError: it is a Parquet file and pyarrow is not installed.
    """
    if is_columnar(path) and not new_headings:
        file = read_exact(path, gaps=True, names=names, units=units, interval=interval)
    else:
        file = tell_guesses(read_one(path, new_headings))
    if file.record.interval is None or file.has_time:
        return file.record
    if interval is None:
        raise DataError(f"`{Path(path).name}` has no column `time`; give the interval between its rows.")
    return file.with_interval(interval).record


def write_sampled(record: Sampled, path: str | Path) -> None:
    """Write a record as text with headings that `read_sampled` reads; missing samples are empty.

    Raises:
        DataError: the file cannot be written.
    """
    names = ("time", *record.input_names, *record.output_names)
    spelled = {"time": "s", **record.units}
    lines = [",".join(f"{name} [{spelled.get(name, '1')}]" for name in names)]
    table = np.column_stack([record.times, record.inputs, record.outputs])
    lines += [",".join("" if math.isnan(v) else f"{v:.9g}" for v in row) for row in table]
    write_file(path, "\n".join([*lines, ""]))
