"""Numeric columns of Parquet, MAT and netCDF files.

MAT and netCDF files are read in a separate process with limits of time and memory, because a damaged file can crash or
block its reader.
"""

from __future__ import annotations

import io
import os
import subprocess
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, cast

import numpy as np

from martensite.base.child_python import python_command, python_environment
from martensite.base.errors import DataError
from martensite.base.files import MOST_LOG, check_ordinary
from martensite.base.lazy import import_extra
from martensite.logs.open_files import TEXT, describe_unreadable

BINARY = (".parquet", ".mat", ".nc", ".h5", ".hdf5")
"""Suffixes of files of arrays."""
LONGEST = 60.0
"""Time limit of a separate process [s], plus the allowance for the file size."""
SLOWEST = 1e7
"""Lowest assumed reading speed [bytes/s]."""
MOST_MEMORY = 2**33
"""Memory limit of a separate process [bytes]."""
_UDUNITS = {"degree_Celsius": "degC", "degrees_Celsius": "degC", "celsius": "degC", "": "1"}
"""Unit in other files -> unit in headings."""
Columns = dict[str, Any]
"""Heading, with or without unit -> numbers."""


def head_column(heading: str, unit: str) -> str:
    """Return a heading with its unit."""
    return heading if "[" in heading or not unit else f"{heading} [{unit}]"


def read_arrays(path: Path) -> dict[str, Any]:
    """Return the columns of a binary file by heading, with the unit if the file contains it.

    Raises:
        DataError: the file is missing, of unknown kind, or malformed.
        InputError: it is a Parquet file and pyarrow is not installed.
    """
    ending = path.suffix.lower()
    if ending not in BINARY:
        raise DataError(f"The log `{path}` has no ending that can be read; use one of {', '.join((*TEXT, *BINARY))}.")
    with describe_unreadable(path):
        size = check_ordinary(path, MOST_LOG)
    return read_apart(path, f"{__spec__.name}:{_APART[ending]}", size) if ending in _APART else _read_parquet(path)


def read_apart(path: Path, reader: str, size: int) -> Columns:
    """Return the columns of a file of `size` bytes, read in a separate process by `reader` (`MODULE:FUNCTION`).

    Raises:
        DataError: the file is damaged, or the reader refuses it.
    """
    environment = python_environment(OPENBLAS_NUM_THREADS="1")
    command, most = python_command("-m", __spec__.name, reader, str(path)), LONGEST + size / SLOWEST
    try:
        done = subprocess.run(command, env=environment, capture_output=True, check=False, timeout=most)
    except subprocess.TimeoutExpired:
        raise DataError(f"`{path.name}` is damaged: it was not read within {most:.0f} s.") from None
    if done.returncode == DataError.exit_code:
        raise DataError(done.stderr.decode("utf-8", "replace"))
    if done.returncode:
        raise DataError(f"`{path.name}` is damaged: the process that read it ended at once.")
    with np.load(io.BytesIO(done.stdout), allow_pickle=False) as arrays:
        return {str(name): arrays[f"column_{k}"] for k, name in enumerate(arrays["names"])}


def _answer_apart(reader: str, path: Path) -> None:
    """Write the columns of a file to standard output, or the error to standard error."""
    with suppress(ImportError, ValueError):  # other systems lack this limit
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    try:
        columns = _read_columns(reader, path)
    except DataError as error:
        os.write(sys.stderr.fileno(), str(error).encode())
        os._exit(DataError.exit_code)  # half-open readers must not print
    numbered = {f"column_{k}": column for k, column in enumerate(columns.values())}
    np.savez(sys.stdout.buffer, names=np.array(list(columns), dtype=str), **numbered)


def _read_columns(reader: str, path: Path) -> Columns:
    module, _, function = reader.partition(":")
    try:
        columns = getattr(import_module(module), function)(path)
    except DataError:
        raise
    except Exception as error:  # binary readers raise errors of any kind
        raise DataError(f"`{path.name}` cannot be read as {path.suffix}: {error!r}.") from None
    if not columns:
        raise DataError(f"`{path.name}` has no numeric columns over time.")
    return columns


# ---------------------------------------------------------------- kinds of files


def _read_parquet(path: Path) -> Columns:
    read = import_extra("pyarrow.parquet", "parquet", "pyarrow").read_table
    try:
        table = read(path)
    except (OSError, ValueError, KeyError) as error:
        raise DataError(f"`{path.name}` cannot be read as .parquet: {error}.") from None
    return {
        name: np.asarray(table[name].to_numpy(zero_copy_only=False), dtype=float)
        for name in table.column_names
        if _is_numeric(str(table.schema.field(name).type))
    }


def _is_numeric(kind: str) -> bool:
    return kind.startswith(("int", "uint", "float", "double", "half", "bool"))


def read_mat(path: Path) -> Columns:
    """Return the vectors, columns of matrices, and logs in structs of a MAT file, by name."""
    from scipy.io import loadmat

    try:
        variables: dict[str, Any] = loadmat(str(path), simplify_cells=True)
    except NotImplementedError:  # version 7.3 is HDF5
        variables = _read_hdf(path)
    columns: Columns = {}
    for name, value in variables.items():
        if not name.startswith(("__", "#")):
            columns |= _flatten_value(name, value)
    if not columns:
        raise DataError(
            f"`{path.name}` has no numeric arrays. Objects such as timeseries, timetable and Dataset cannot be "
            "read outside MATLAB: save plain variables, or a struct such as `s.time = ts.Time; s.force = ts.Data`."
        )
    return {"time" if name == "t" and "time" not in columns else name: column for name, column in columns.items()}


def _read_hdf(path: Path) -> dict[str, Any]:
    """Return the arrays and structs of a MAT file of version 7.3, which stores arrays transposed."""
    import h5py

    def read_group(group: Any) -> dict[str, Any]:
        return {
            name: read_group(value) if isinstance(value, h5py.Group) else np.asarray(value).T
            for name, value in group.items()
            if not name.startswith("#")
        }

    with h5py.File(path, "r") as file:
        return read_group(file)


def read_hdf(path: Path) -> Columns:
    """Return the vectors and columns of matrices of an HDF5 file, by name, with the unit in attribute `units`."""
    import h5py

    columns: Columns = {}

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            unit = str(item.attrs.get("units", ""))
            unit = _UDUNITS.get(unit, unit) if unit else ""
            parts = _flatten_value(name.replace("/", "."), np.asarray(item))
            columns.update({head_column(part, unit): column for part, column in parts.items()})

    with h5py.File(path, "r") as file:
        file.visititems(visit)
    return columns


def _flatten_value(name: str, value: Any) -> Columns:
    """Return the columns of a variable, including fields of structs and signals of Simulink's struct with time."""
    if isinstance(value, dict):
        return _flatten_struct(name, cast("dict[str, Any]", value))
    whole = np.asarray(value)
    if whole.dtype.kind not in "iufb" or whole.ndim > 2 or whole.size < 2:
        return {}
    if whole.ndim == 1 or 1 in whole.shape:
        return {name: whole.ravel().astype(float)}
    if whole.shape[0] < whole.shape[1] and np.all(np.diff(whole[0]) > 0.0):  # as Simulink's block To File writes it
        rows = {f"{name}{k}": row.astype(float) for k, row in enumerate(whole[1:], 1)}
        return {"time": whole[0].astype(float)} | rows
    return {f"{name}{k}": column.astype(float) for k, column in enumerate(whole.T, start=1)}


def _flatten_struct(name: str, fields: dict[str, Any]) -> Columns:
    signals, time = fields.get("signals"), fields.get("time", fields.get("Time"))
    if signals is not None and time is not None:
        listed = cast("list[Any]", signals) if isinstance(signals, list) else [signals]
        labels = [one.get("label") for one in listed]
        named = [label if isinstance(label, str) and label else f"{name}{k}" for k, label in enumerate(labels, 1)]
        parts = {label: one["values"] for label, one in zip(named, listed, strict=True)}
    elif time is not None and "Data" in fields:
        parts = {name: fields["Data"]}
    else:
        return {k: c for part, inner in fields.items() for k, c in _flatten_value(part, inner).items()}
    columns: Columns = {"time": np.asarray(time, dtype=float).ravel()}
    for part, inner in parts.items():
        columns |= _flatten_value(part, inner)
    return columns


def read_netcdf(path: Path) -> Columns:
    """Return the variables over one dimension, preferably time; a second dimension of texts gives one column each."""
    import h5netcdf

    columns: Columns = {}
    with h5netcdf.File(path, "r", decode_vlen_strings=True) as file:
        own = file.variables["time"].dimensions if "time" in file.variables else None
        for name, variable in file.variables.items():
            if variable.dtype.kind not in "iuf" or not variable.dimensions:
                continue
            unit = str(variable.attrs.get("units", ""))
            unit = _UDUNITS.get(unit, unit)
            (along, *across), values = variable.dimensions, np.asarray(variable[...])
            labels = file.variables[across[0]] if len(across) == 1 and across[0] in file.variables else None
            parts = {name: values}
            if labels is not None and values.ndim == 2 and labels.dtype.kind == "O":
                parts = {f"{label}.{name}": column for label, column in zip(labels[...], values.T, strict=True)}
            elif across:
                continue
            if own in (None, (along,)):
                columns |= {head_column(part, unit): column for part, column in parts.items()}
    return columns


_APART = {".mat": read_mat.__name__, ".nc": read_netcdf.__name__, ".h5": read_hdf.__name__, ".hdf5": read_hdf.__name__}
"""Readers that run in a separate process, by suffix."""

if __name__ == "__main__":
    _answer_apart(sys.argv[1], Path(sys.argv[2]))
