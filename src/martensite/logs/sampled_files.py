"""Logs in text, Parquet, MAT and netCDF files, as tables (`Record`) and as records of samples (`Sampled`).

| ending | read as |
|---|---|
| .csv .txt .tsv .dat, `data:SET/FILE` | text with headings `name [unit]` (`logs.tables`) |
| .parquet | table with column names like these headings; needs pyarrow |
| .mat | variables by name, of version 5 (SciPy) or 7.3 (HDF5); no structs |
| .nc | variables over time, with their attribute `units`; of several actuators, as `PORT.NAME` |

A column that has no unit in its file is in the one given in `units`; those in `units` are also the units of the result.
A column `t` is one of time in MAT files, in seconds if it says nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from martensite.base.errors import DataError, suggest_name
from martensite.base.files import write_file
from martensite.base.units import find_conversion
from martensite.logs.binary_files import Columns, head_column, name_column, read_arrays
from martensite.logs.layout import CANONICAL, CLOCK, IGNORED, read_headings
from martensite.logs.tables import ASSUMED_INTERVAL, BINARY, PREFIX
from martensite.signals.records import Record, out_of_order
from martensite.signals.sampling.regular_grid import from_record, split_at_gaps
from martensite.signals.sampling.sampled import Sampled


def read_sampled(
    path: str | Path,
    inputs: Sequence[str],
    outputs: Sequence[str],
    interval: float | None = None,
    units: Mapping[str, str] | None = None,
) -> Sampled:
    """Read a log as a record at equal intervals; `signals.sampling.regular_grid` says how.

    Args:
        path: the file, or `data:<data set>/<file>`.
        inputs: columns that go in.
        outputs: columns that come out.
        interval: sample time [s]; by default that of the rows. Where the file has no times, the time between rows.
        units: units of columns, such as `{"position": "mm"}`; by default those that people read.

    Raises:
        DataError: the file is missing, of no known kind, malformed, or lacks a column.
        InputError: it is a Parquet file and pyarrow is not installed.
    """
    record = read_log(path, (*inputs, *outputs), interval, units or {})
    return from_record(record, inputs, outputs, interval, units)


def read_pieces(
    path: str | Path,
    inputs: Sequence[str],
    outputs: Sequence[str],
    interval: float | None = None,
    units: Mapping[str, str] | None = None,
    named: Mapping[str, str] | None = None,
) -> tuple[Sampled, ...]:
    """Read a log as `read_sampled` does, split where its inputs have gaps (`regular_grid.split_at_gaps`)."""
    record = read_log(path, (*inputs, *outputs), interval, units or {}, named)
    return split_at_gaps(record, inputs, outputs, interval, units)


def read_log(
    path: str | Path,
    names: Sequence[str],
    interval: float | None,
    units: Mapping[str, str],
    named: Mapping[str, str] | None = None,
) -> Record:
    """Return the chosen columns of a log as a table in SI; all columns of a text file, or if `named` is given.

    Raises:
        DataError: the file is missing, of no known kind, malformed, or lacks a column.
        InputError: it is a Parquet file and pyarrow is not installed.
    """
    if named or not is_columnar(path):
        return _read_text(path, interval, named)
    path = Path(path)
    found = read_arrays(path)
    plain = {name_column(heading): heading for heading in found}
    headed: Columns = {}
    for name in dict.fromkeys([*(("time",) if "time" in plain else ()), *names]):
        if name not in plain:
            raise DataError(f"`{path.name}` has no column `{name}`. {suggest_name(name, plain)}")
        unit = units.get(name, "s" if name == "time" else "")
        headed[head_column(plain[name], unit)] = found[plain[name]]
    if "time" not in plain and interval is None:
        raise DataError(f"`{path.name}` has no column `time`; give the interval between its rows.")
    return _build_record(path, headed, interval, gaps=True)


def read_array_table(path: Path, columns: Sequence[str] | None, interval: float | None, gaps: bool) -> Record:
    """Read all columns of a binary file over time, in SI; arguments and errors as in `read_table`."""
    found = read_arrays(path)
    length = len(found.get("time", found.get("time [s]", max(found.values(), key=len))))
    found = {heading: values for heading, values in found.items() if len(values) == length}
    if columns is not None and len(columns) != len(found):
        raise DataError(f"`{path.name}` holds {len(found)} columns, but {len(columns)} are named: {_list(found)}.")
    if columns is not None:
        found = {new: values for new, values in zip(columns, found.values(), strict=True) if new != IGNORED}
    found = {head_column(name, "s") if name == "time" else name: values for name, values in found.items()}
    unknown = [name for name in found if "[" not in name and CANONICAL.get(name.rpartition(".")[2], "1") != "1"]
    if unknown:
        raise DataError(
            f"`{path.name}` does not say in which unit {_list(unknown)} is; name all its columns with units, such "
            f'as "temperature [degC]", in this order: {_list(found)}.'
        )
    return _build_record(path, found, ASSUMED_INTERVAL if interval is None else interval, gaps)


def is_columnar(path: str | Path) -> bool:
    """Return whether a log is a file of named arrays, and not of a published data set."""
    return not str(path).startswith(PREFIX) and Path(path).suffix.lower() in BINARY


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


def _read_text(path: str | Path, interval: float | None, named: Mapping[str, str] | None) -> Record:
    """Read a text table; `interval` applies only to tables without a time column."""
    from martensite.logs.log_tables import read_log_table

    record = read_log_table(path, named=named)
    if record.interval is None:
        return record
    if interval is None:
        raise DataError(f"`{Path(path).name}` has no column `time`; give the interval between its rows.")
    return read_log_table(path, interval=interval, named=named)


def _list(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _build_record(path: Path, found: Columns, interval: float | None, gaps: bool) -> Record:
    """Return the columns by their headings, in SI, with NaN for missing samples if there may be such `gaps`."""
    columns: dict[str, list[float]] = {}
    units: dict[str, str] = {}
    for column, values in zip(read_headings(found, f"`{path.name}`"), found.values(), strict=True):
        name = column.name
        if column.spelling in (CLOCK, IGNORED):
            raise DataError(f"`{path.name}`: column `{name}` must hold numbers.")
        may_lack = gaps and name != "time"
        rows = np.flatnonzero(np.isinf(values) if may_lack else ~np.isfinite(values))
        if rows.size:
            fault = "infinite" if np.isinf(values[rows[0]]) else "no number"
            raise DataError(f"`{path.name}`: column `{name}` is {fault} at row {rows[0]}.")
        factor, offset = (1.0, 0.0) if column.spelling == column.unit else find_conversion(column.spelling, column.unit)
        columns[name] = (np.asarray(values, dtype=float) * factor + offset).tolist()
        units[name] = column.unit
    if "time" not in columns:
        apart = ASSUMED_INTERVAL if interval is None else interval
        times = [k * apart for k in range(len(next(iter(columns.values()))))]
        return Record(path.stem, columns | {"time": times}, units | {"time": "s"}, path, interval=interval)
    row = out_of_order(columns["time"])
    if row is not None:
        raise DataError(f"`{path.name}`: time must increase from row to row, but not at row {row}.")
    return Record(path.stem, columns, units, path)
