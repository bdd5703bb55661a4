"""Files of results: written in the format of the suffix, and opened as a `Result`."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from martensite.actuators.assembly import PROFILES
from martensite.base.errors import DataError
from martensite.base.files import replace_file
from martensite.base.lazy import import_extra
from martensite.base.object_text import decode
from martensite.logs.record_text import format_heading
from martensite.scenario.csv_files import list_columns, write_csv
from martensite.scenario.netcdf import (
    KEPT_RESULT,
    TIME,
    VARIANT,
    LabelledData,
    list_stacked,
    read_labelled,
    read_restarts,
    save_result,
)
from martensite.simulate.result import Result


def save_by_suffix(result: Result, path: str | os.PathLike[str]) -> None:
    """Write a result in the format of the suffix of the file.

    Raises:
        DataError: the suffix is unknown, or the file cannot be written.
        InputError: a Parquet file needs pyarrow, which is not installed.
    """
    write = WRITERS.get(Path(path).suffix.lower())
    if write is None:
        raise DataError(f"`{path}` has no suffix of a result file; use {', '.join(WRITERS)}.")
    write(result, path)


def _write_parquet(result: Result, path: str | os.PathLike[str]) -> None:
    arrow: Any = import_extra("pyarrow", "parquet", "pyarrow")
    write: Any = import_extra("pyarrow.parquet", "parquet", "pyarrow").write_table
    table = arrow.table({format_heading(name, unit): values for name, unit, values in list_columns(result)})
    with replace_file(Path(path)) as part:
        write(table, part)


WRITERS = {".nc": save_result, ".csv": write_csv, ".parquet": _write_parquet}


def open_result(path: str | os.PathLike[str]) -> Result:
    """Return a result that `save` wrote as netCDF.

        ms.open_result("a.nc")["temperature"], ms.open_result("a.nc").plot()

    Args:
        path: file with the suffix `.nc`.

    Returns:
        The result with its columns, accuracy, balances, alarms, warnings and restarts.

    Raises:
        DataError: the file does not exist, is not a result, or has a part whose module is not imported.
    """
    saved = read_labelled(path)
    if KEPT_RESULT not in saved.attrs:
        raise DataError(
            f"`{path}` holds columns, but not what was simulated; read them with `xarray.open_dataset` "
            "or `ms.read_table`."
        )
    try:
        own = decode(json.loads(saved.attrs[KEPT_RESULT]))
        extremes = own.pop("extremes")
        empty = Result(**own, times=np.empty(0), columns={})
    except DataError as error:
        raise DataError(f"`{path}` cannot be opened as a result: {error}") from None
    except (ValueError, TypeError, LookupError, AttributeError, ImportError, RecursionError) as error:
        raise DataError(f"`{path}` cannot be opened as a result: {error!r}.") from None
    result = _fill(empty, saved)
    result.__dict__["extremes"] = extremes  # of accepted steps, which the file does not hold
    return result


def _fill(empty: Result, saved: LabelledData) -> Result:
    """Return a result with the variables of its file."""
    return replace(
        empty,
        times=saved[TIME].values,
        columns=_read_columns(empty, saved),
        profiles={name: saved[name].values.T.tolist() for name in PROFILES if name in saved.variables},
        restarts=read_restarts(saved)[0],
    )


def _read_columns(empty: Result, saved: LabelledData) -> dict[str, Any]:
    """Return the columns by name; the file stacks the columns of several actuators."""
    if empty.variants is not None:
        return {name: one.values for name, one in saved.variables.items() if one.dims == (VARIANT, TIME)}
    stacked = {
        label: saved[name].values[:, place]
        for place, labels in enumerate(list_stacked(empty))
        for name, label in labels.items()
    }
    return {name: stacked[name] if name in stacked else saved[name].values for name in empty.outputs}
