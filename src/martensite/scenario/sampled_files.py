"""Logs for identification: text tables, Parquet, MAT and netCDF files as `Sampled`.

| ending | read as |
|---|---|
| .csv .txt .tsv .dat, `data:SET/FILE` | text with headings `name [unit]` (`scenario.tables`) |
| .parquet | table with column names like these headings; needs pyarrow |
| .mat | variables by name, of version 5 (SciPy) or 7.3 (HDF5); no structs |
| .nc | variables over one dimension, with their attribute `units` |

MAT and netCDF files are read in a process of their own: a damaged one can end the process that reads it. A column
that has no unit in its file is in the one given in `units`; those in `units` are also the units of the result. A
column `t` is one of time in MAT files, in seconds if it says nothing.
"""

from __future__ import annotations

import io
import math
import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from martensite.base import units as unit_table
from martensite.base.errors import DataError, suggest_name
from martensite.base.files import write_file
from martensite.base.lazy import import_extra
from martensite.scenario.layout import CLOCK, IGNORED, read_headings
from martensite.scenario.tables import PREFIX, read_table
from martensite.signals.records import Record, out_of_order
from martensite.signals.sampling.regular_grid import from_record, split_at_gaps
from martensite.signals.sampling.sampled import Sampled

TEXT = (".csv", ".txt", ".tsv", ".dat")
_UDUNITS = {"degree_Celsius": "degC", "degrees_Celsius": "degC", "celsius": "degC", "": "1"}
"""Spellings of other files -> those of headings."""


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
) -> tuple[Sampled, ...]:
    """Read a log as `read_sampled` does, split where its inputs have gaps (`regular_grid.split_at_gaps`)."""
    record = read_log(path, (*inputs, *outputs), interval, units or {})
    return split_at_gaps(record, inputs, outputs, interval, units)


def read_log(path: str | Path, names: Sequence[str], interval: float | None, units: Mapping[str, str]) -> Record:
    """A log of any kind as a table in SI, with the columns named (text: with all).

    Raises:
        DataError: the file is missing, of no known kind, malformed, or lacks a column.
        InputError: it is a Parquet file and pyarrow is not installed.
    """
    ending = "" if str(path).startswith(PREFIX) else Path(path).suffix.lower()
    if str(path).startswith(PREFIX) or ending in TEXT:
        return _read_text(path, interval)
    return _build_table(Path(path), read_arrays(Path(path)), names, interval, units)


def read_arrays(path: Path) -> dict[str, Any]:
    """Columns of a file that is no text, by heading, with its unit if the file knows it.

    Raises:
        DataError: the file is missing, of no known kind, or malformed.
        InputError: it is a Parquet file and pyarrow is not installed.
    """
    ending = path.suffix.lower()
    if ending not in (".parquet", *_APART):
        known = ", ".join((*TEXT, ".parquet", *_APART))
        raise DataError(f"The log `{path}` has no ending that can be read; use one of {known}.")
    if not path.is_file():
        raise DataError(f"There is no file `{path}`.")
    return _read_apart(path) if ending in _APART else _read_parquet(path)


def _read_apart(path: Path) -> _Columns:
    """Columns that a process of its own finds in a file."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-m", "martensite.scenario.sampled_files", str(path)]
    done = subprocess.run(command, env=environment, capture_output=True, check=False)
    if done.returncode == DataError.exit_code:
        raise DataError(done.stderr.decode("utf-8", "replace"))
    if done.returncode:
        raise DataError(f"`{path.name}` is damaged: the process that read it ended at once.")
    with np.load(io.BytesIO(done.stdout), allow_pickle=False) as found:
        return {str(name): found[f"column_{k}"] for k, name in enumerate(found["names"])}


def _answer_apart(path: Path) -> None:
    """Write the columns of a file to the standard output, or why there are none as an error."""
    try:
        found = _APART[path.suffix.lower()](path)
    except Exception as error:  # readers of binary files let errors of any kind pass
        words = f"`{path.name}` cannot be read as {path.suffix}: {error!r}."
        words = str(error) if isinstance(error, DataError) else words
        os.write(sys.stderr.fileno(), words.encode())
        os._exit(DataError.exit_code)  # nothing that a reader left half open may speak
    columns = {f"column_{k}": column for k, column in enumerate(found.values())}
    np.savez(sys.stdout.buffer, names=np.array(list(found), dtype=str), **columns)


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


def _read_text(path: str | Path, interval: float | None) -> Record:
    """A text table; the interval is that of the rows only where there is no time."""
    record = read_table(path, gaps=True)
    if record.interval is None:
        return record
    if interval is None:
        raise DataError(f"`{Path(path).name}` has no column `time`; give the interval between its rows.")
    return read_table(path, interval=interval, gaps=True)


# ---------------------------------------------------------------- columns by heading

_Columns = dict[str, Any]
"""Heading, with or without unit -> numbers."""


def _build_table(
    path: Path, found: _Columns, names: Sequence[str], interval: float | None, units: Mapping[str, str]
) -> Record:
    plain = {heading.partition("[")[0].strip().lower(): heading for heading in found}
    wanted = dict.fromkeys([*(("time",) if "time" in plain else ()), *names])
    columns: dict[str, list[float]] = {}
    spelled: dict[str, str] = {}
    for name in wanted:
        if name not in plain:
            raise DataError(f"`{path.name}` has no column `{name}`. {suggest_name(name, plain)}")
        heading = plain[name]
        unit = units.get(name, "s" if name == "time" else "")
        headed = heading if "[" in heading or not unit else f"{heading} [{unit}]"
        (column,) = read_headings([headed], f"`{path.name}`")
        if column.spelling in (CLOCK, IGNORED):
            raise DataError(f"`{path.name}`: column `{name}` must hold numbers.")
        row = next((k for k, value in enumerate(found[heading]) if math.isinf(value)), None)
        if row is not None:
            raise DataError(f"`{path.name}`: column `{name}` is infinite at row {row}.")
        factor, offset = unit_table.find_conversion(column.spelling, column.unit)
        columns[name] = [float(value) * factor + offset for value in found[heading]]
        spelled[name] = column.unit
    return _add_times(path, columns, spelled, interval)


def _add_times(path: Path, columns: dict[str, list[float]], units: dict[str, str], interval: float | None) -> Record:
    if "time" not in columns:
        if interval is None:
            raise DataError(f"`{path.name}` has no column `time`; give the interval between its rows.")
        count = len(next(iter(columns.values())))
        columns, units = columns | {"time": [k * interval for k in range(count)]}, units
        return Record(path.stem, columns, units | {"time": "s"}, path, interval=interval)
    row = out_of_order(columns["time"])
    if row is not None:
        raise DataError(f"`{path.name}`: time must increase from row to row, but not at row {row}.")
    return Record(path.stem, columns, units, path)


# ---------------------------------------------------------------- kinds of files


def _read_parquet(path: Path) -> _Columns:
    table = _open_file(path, import_extra("pyarrow.parquet", "parquet", "pyarrow").read_table)
    return {
        name: np.asarray(table[name].to_numpy(zero_copy_only=False), dtype=float)
        for name in table.column_names
        if _is_numeric(str(table.schema.field(name).type))
    }


def _is_numeric(kind: str) -> bool:
    return kind.startswith(("int", "uint", "float", "double", "half", "bool"))


def _read_mat(path: Path) -> _Columns:
    from scipy.io import loadmat

    try:
        found: dict[str, Any] = loadmat(str(path))
    except NotImplementedError:  # version 7.3 is HDF5
        found = _open_file(path, _read_hdf)
    except (ValueError, OSError, TypeError) as error:
        raise DataError(f"`{path.name}` cannot be read as a MAT file: {error}.") from None
    columns = _flatten_arrays({n: a for n, a in found.items() if not n.startswith("__")})
    if not columns:
        raise DataError(
            f"`{path.name}` holds no arrays of numbers; save signals as plain variables, not in structs or timetables."
        )
    if "t" in columns and "time" not in columns:
        columns["time"] = columns.pop("t")
    return columns


def _read_hdf(path: Path) -> dict[str, Any]:
    """Arrays of a MAT file of version 7.3, which stores them transposed."""
    import h5py

    with h5py.File(path, "r") as file:
        return {n: np.asarray(v).T for n, v in file.items() if isinstance(v, h5py.Dataset)}


def _flatten_arrays(arrays: Mapping[str, Any]) -> _Columns:
    """Vectors by name, and columns of matrices as name1, name2, …; others are passed over."""
    columns: _Columns = {}
    for name, array in arrays.items():
        whole = np.asarray(array)
        if whole.dtype.kind not in "iufb" or whole.ndim > 2 or whole.size < 2:
            continue
        if whole.ndim == 1 or 1 in whole.shape:
            columns[name] = whole.ravel().astype(float)
        else:
            columns |= {f"{name}{k}": c.astype(float) for k, c in enumerate(whole.T, start=1)}
    return columns


def _read_netcdf(path: Path) -> _Columns:
    import h5netcdf

    def read(path: Path) -> _Columns:
        columns: _Columns = {}
        with h5netcdf.File(path, "r") as file:
            for name, variable in file.variables.items():
                if len(variable.dimensions) == 1 and variable.dtype.kind in "iuf":
                    unit = str(variable.attrs.get("units", ""))
                    unit = _UDUNITS.get(unit, unit)
                    columns[f"{name} [{unit}]" if unit else name] = np.asarray(variable[...])
        return columns

    return _open_file(path, read)


def _open_file(path: Path, read: Callable[[Path], Any]) -> Any:
    try:
        return read(path)
    except (OSError, ValueError, KeyError) as error:
        raise DataError(f"`{path.name}` cannot be read as {path.suffix}: {error}.") from None


_APART = {".mat": _read_mat, ".nc": _read_netcdf}

if __name__ == "__main__":
    _answer_apart(Path(sys.argv[1]))
