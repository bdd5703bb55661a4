"""Reading of a sweep: columns with one value per run, summaries, or an xarray dataset.

Runs of a missing chunk have the status `NOT_MADE` (-1) and no values. The variables of the dataset are read on demand:

    values     measures and traces, in SI; NaN for a failed or missing run, but traces of runs that left the envelope
               are kept
    status     end of every run (`martensite.base.status`); -1 for a missing run
    ended, accuracy  time of the end [s], and error bound as a fraction of ranges
    coordinates  varied parameters, and times of traces
    attributes  scenario and request

With dask installed, only the status is read at first. Varied parameters of missing runs are NaN, except on a grid.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.status import Status
from martensite.design.sweep.axes import parse_axis
from martensite.design.sweep.plan import DETAILS
from martensite.design.sweep.store import RUN, STATUS, Store
from martensite.design.sweep.table import NOT_MADE, SweepColumn, SweepTable
from martensite.search.free_numbers import FreeNumber, Target

if TYPE_CHECKING:
    import xarray


def read_sweep(path: Path | str) -> SweepTable:
    """Return the finished runs of a sweep.

    Args:
        path: Zarr store, which may be incomplete.

    Raises:
        DataError: the store is no sweep, or is damaged.
        InputError: Zarr is not installed.
    """
    store = Store(Path(path))
    store.require_sound()
    status = read_status(store)
    axes = read_axes(store)
    absent = status == NOT_MADE
    names = [one.target.name for one in axes]
    logs = {one.target.name: one.logarithmic for one in axes}
    columns = {
        name: _read_column(store, name, absent, logs.get(name, False)) for name in (*names, *store.spec["measures"])
    }
    return SweepTable(
        title=store.spec["title"],
        sample=store.spec["sample"],
        varied={name: columns[name] for name in names},
        measures={name: columns[name] for name in store.spec["measures"]},
        status=status,
        levels=read_levels(store, axes),
    )


def read_status(store: Store) -> NDArray[np.int8]:
    """Return the status of every run; `NOT_MADE` for a missing chunk."""
    status = np.asarray(store.group[STATUS][:], np.int8)
    places = np.arange(len(status)) // int(store.spec["chunk"])
    return np.where(np.isin(places, list(store.list_finished_chunks())), status, np.int8(NOT_MADE))


def read_axes(store: Store) -> list[FreeNumber]:
    """Return the axes in their requested order; of a normal axis only the kind is valid.

    The scenario is not read again, because it may need parts of the user.
    """
    targets = {
        str(name): Target(str(name), str(name), array.attrs["units"], 1.0)
        for name, array in store.group.arrays()
        if array.attrs.get("role") == "varied"
    }
    return [parse_axis(words, targets) for words in store.spec["over"]]


def read_levels(store: Store, axes: list[FreeNumber]) -> tuple[Any, ...] | None:
    """Return the levels of every axis of a grid; None for other designs."""
    if store.spec["sample"].strip() != "grid":
        return None
    return tuple(one.levels() for one in axes)


def _read_column(store: Store, name: str, absent: NDArray[np.bool_], log: bool) -> SweepColumn:
    array = store.group[name]
    values = np.where(absent, np.nan, np.asarray(array[:], float))
    return SweepColumn(name, str(array.attrs["units"]), values, log)


# ---------------------------------------------------------------- in a few numbers


def count_statuses(store: Store, named: int) -> tuple[Counter[int], dict[int, list[int]]]:
    """Return the number of runs by status, and the first few runs of each that is not OK."""
    counts, rows = Counter[int](), dict[int, list[int]]()
    for stretch, there in store.stretches():
        statuses = np.where(there, store.group[STATUS][stretch], -1)
        for status in Status:
            places = np.flatnonzero(statuses == status)
            counts[status] += len(places)
            if status is not Status.OK and len(places):
                first = rows.setdefault(status, [])
                first += (places[: named - len(first)] + stretch.start).tolist()
    return counts, rows


def count_above(store: Store, column: str, bound: float) -> int:
    """Return the number of values of a column above a bound."""
    stretches = store.stretches()
    return sum(int(np.sum(store.group[column][place][there] > bound)) for place, there in stretches)


def compute_spread(store: Store, column: str) -> tuple[float, float, float]:
    """Return lowest, median and highest finite value of a column, or NaN."""
    values = np.concatenate([_read_finite(store, column, *one) for one in store.stretches()])
    if not len(values):
        return math.nan, math.nan, math.nan
    lowest, highest = float(values.min()), float(values.max())
    return lowest, float(np.median(values, overwrite_input=True)), highest


def _read_finite(store: Store, column: str, place: slice, there: NDArray[np.bool_]) -> NDArray[np.float64]:
    values = np.asarray(store.group[column][place], float)
    return values[there & np.isfinite(values)]


# ---------------------------------------------------------------- as a dataset


PRIVATE = ("folder", "modules", "chunk", "traces")
"""Entries of the request that are internal or contained in the variables."""


def open_sweep(path: Path | str, grid: bool = True) -> xarray.Dataset:
    """Open the store of a sweep.

    Args:
        path: Zarr group.
        grid: use the axes of a grid as dimensions; otherwise there is one dimension `run`.

    Raises:
        DataError: the sweep does not exist or is damaged.
        InputError: Zarr or xarray is not installed.
    """
    import xarray

    store = Store(Path(path))
    store.require_sound()
    axes, status = read_axes(store), read_status(store)
    opened = xarray.open_zarr(str(path), consolidated=False, decode_times=False, decode_timedelta=False)
    names = [one.target.name for one in axes]
    traces = [name for name, _ in store.spec["traces"]]
    variables = [*store.spec["measures"], *traces, *DETAILS, STATUS]
    dataset = opened.set_coords(names)[variables].assign({STATUS: (RUN, status, _describe_status(opened))})
    dataset = _mask_failed(dataset, status, (*traces, *DETAILS))
    levels = read_levels(store, axes)
    if grid and levels is not None:
        dataset = _arrange_grid(xarray, dataset, dict(zip(names, levels, strict=True)))
    else:
        dataset = dataset.assign_coords({RUN: np.arange(len(status))})
    dataset.attrs = _describe_request(store)
    return dataset


def _describe_status(opened: xarray.Dataset) -> dict[str, Any]:
    """Return the attributes of the status, with the value for missing runs."""
    attributes = dict(opened[STATUS].attrs)
    values = np.array([NOT_MADE, *attributes["flag_values"]], np.int8)
    return {**attributes, "flag_values": values, "flag_meanings": f"not_made {attributes['flag_meanings']}"}


def _mask_failed(dataset: xarray.Dataset, status: Any, partial: Sequence[str]) -> xarray.Dataset:
    """Return NaN for failed and missing runs; `partial` columns are kept if the envelope was left."""
    good = (status > NOT_MADE) & (status < Status.UNSOLVED)
    if good.all():
        return dataset
    all_of_it = dataset[STATUS].copy(data=good)
    some_of_it = dataset[STATUS].copy(data=good | (status == Status.OUT_OF_ENVELOPE))
    numbers = dataset.drop_vars(STATUS)
    masked = {n: one.where(some_of_it if n in partial else all_of_it) for n, one in numbers.items()}
    return dataset.assign(masked)


def _arrange_grid(xarray: Any, dataset: xarray.Dataset, levels: Mapping[str, Any]) -> xarray.Dataset:
    """Return the dataset with one dimension per axis."""
    shape = tuple(map(len, levels.values()))
    variables = {name: _fold_runs(one, tuple(levels), shape) for name, one in dataset.data_vars.items()}
    times = {name: one for name, one in dataset.coords.items() if RUN not in one.dims}
    coords = {name: (name, values, dataset[name].attrs) for name, values in levels.items()}
    return xarray.Dataset(variables, {**coords, **times})


def _fold_runs(one: Any, names: tuple[str, ...], shape: tuple[int, ...]) -> Any:
    """Split the first dimension of a variable (the runs) into the dimensions of the grid."""
    data = one.variable.data
    return (*names, *one.dims[1:]), data.reshape(*shape, *one.shape[1:]), one.attrs


def _describe_request(store: Store) -> dict[str, Any]:
    """Return the request as attributes for netCDF."""
    entries = {n: v for n, v in store.spec.items() if n not in PRIVATE and v is not None}
    plain = (str, int, float, list)
    return {n: v if isinstance(v, plain) else json.dumps(v) for n, v in entries.items()}
