"""Opening a sweep: as columns with one number per run, in a few numbers, or as an xarray dataset.

A chunk that is not made has no numbers, and its runs the status `NOT_MADE` (-1). The dataset is read when it is
needed:

    values     measures and traces, in SI; NaN where a run failed or is not made, but traces of runs
               that left the envelope go as far as these came
    status     how every run ended (`martensite.base.status`); -1 where it is not made yet
    ended, accuracy  when it ended [s], and how far it may be off, as a share of ranges
    coordinates  the varied numbers, and the times of traces
    attributes  the scenario and all that was asked for

With dask installed, nothing but the status is in memory before it is asked for. Varied numbers of
runs that are not made are NaN, except on a grid.
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
    """Return the runs of a sweep, as far as they are made.

    Args:
        path: its Zarr store; it may still be written.

    Raises:
        DataError: it holds no sweep, or is damaged.
        InputError: Zarr is not installed.
    """
    store = Store(Path(path))
    store.require_sound()
    status = read_status(store)
    axes = read_axes(store)
    gone = status == NOT_MADE
    names = [one.target.name for one in axes]
    logs = {one.target.name: one.logarithmic for one in axes}
    columns = {
        name: _read_column(store, name, gone, logs.get(name, False)) for name in (*names, *store.spec["measures"])
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
    """Return the status of every run; `NOT_MADE` where its chunk is not there."""
    status = np.asarray(store.group[STATUS][:], np.int8)
    places = np.arange(len(status)) // int(store.spec["chunk"])
    return np.where(np.isin(places, list(store.made())), status, np.int8(NOT_MADE))


def read_axes(store: Store) -> list[FreeNumber]:
    """Axes in the order in which they were asked for; of a normal one only the kind is to be used.

    The scenario is not read again: it may need parts of the user's own.
    """
    targets = {
        str(name): Target(str(name), str(name), array.attrs["units"], 1.0)
        for name, array in store.group.arrays()
        if array.attrs.get("role") == "varied"
    }
    return [parse_axis(words, targets) for words in store.spec["over"]]


def read_levels(store: Store, axes: list[FreeNumber]) -> tuple[Any, ...] | None:
    """Return the levels of every axis of a grid; None of other designs."""
    if store.spec["sample"].strip() != "grid":
        return None
    return tuple(one.levels() for one in axes)


def _read_column(store: Store, name: str, gone: NDArray[np.bool_], log: bool) -> SweepColumn:
    array = store.group[name]
    values = np.where(gone, np.nan, np.asarray(array[:], float))
    return SweepColumn(name, str(array.attrs["units"]), values, log)


# ---------------------------------------------------------------- in a few numbers


def count_statuses(store: Store, named: int) -> tuple[Counter[int], dict[int, list[int]]]:
    """Return the number of runs by status, and the first few runs of each that is not OK."""
    counts, rows = Counter[int](), dict[int, list[int]]()
    for stretch, there in store.stretches():
        found = np.where(there, store.group[STATUS][stretch], -1)
        for status in Status:
            places = np.flatnonzero(found == status)
            counts[status] += len(places)
            if status is not Status.OK and len(places):
                known = rows.setdefault(status, [])
                known += (places[: named - len(known)] + stretch.start).tolist()
    return counts, rows


def count_above(store: Store, column: str, bound: float) -> int:
    """Return the number of values of a column above a bound."""
    stretches = store.stretches()
    return sum(int(np.sum(store.group[column][place][there] > bound)) for place, there in stretches)


def compute_spread(store: Store, column: str) -> tuple[float, float, float]:
    """Lowest, median and highest of the finite numbers of a column; NaN where there is none."""
    found = np.concatenate([_read_finite(store, column, *one) for one in store.stretches()])
    if not len(found):
        return math.nan, math.nan, math.nan
    lowest, highest = float(found.min()), float(found.max())
    return lowest, float(np.median(found, overwrite_input=True)), highest


def _read_finite(store: Store, column: str, place: slice, there: NDArray[np.bool_]) -> NDArray[np.float64]:
    values = np.asarray(store.group[column][place], float)
    return values[there & np.isfinite(values)]


# ---------------------------------------------------------------- as a dataset


PRIVATE = ("folder", "modules", "chunk", "traces")
"""Entries of the request without meaning elsewhere, or contained in the variables."""


def open_sweep(path: Path | str, grid: bool = True) -> xarray.Dataset:
    """Open the store of a sweep.

    Args:
        path: the Zarr group.
        grid: make the axes of a grid dimensions; otherwise, and for samples, there is one
            dimension `run`.

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
    kept = [*store.spec["measures"], *traces, *DETAILS, STATUS]
    made = opened.set_coords(names)[kept].assign({STATUS: (RUN, status, _describe_status(opened))})
    made = _mask_failed(made, status, (*traces, *DETAILS))
    levels = read_levels(store, axes)
    if grid and levels is not None:
        made = _arrange_grid(xarray, made, dict(zip(names, levels, strict=True)))
    else:
        made = made.assign_coords({RUN: np.arange(len(status))})
    made.attrs = _describe_request(store)
    return made


def _describe_status(opened: xarray.Dataset) -> dict[str, Any]:
    """Attributes of the status, that of runs which are not made among its values."""
    known = dict(opened[STATUS].attrs)
    values = np.array([NOT_MADE, *known["flag_values"]], np.int8)
    return {**known, "flag_values": values, "flag_meanings": f"not_made {known['flag_meanings']}"}


def _mask_failed(made: xarray.Dataset, status: Any, partial: Sequence[str]) -> xarray.Dataset:
    """NaN in runs that failed or are not made; `partial` is known where the envelope was left."""
    good = (status > NOT_MADE) & (status < Status.UNSOLVED)
    if good.all():
        return made
    all_of_it = made[STATUS].copy(data=good)
    some_of_it = made[STATUS].copy(data=good | (status == Status.OUT_OF_ENVELOPE))
    numbers = made.drop_vars(STATUS)
    masked = {n: one.where(some_of_it if n in partial else all_of_it) for n, one in numbers.items()}
    return made.assign(masked)


def _arrange_grid(xarray: Any, made: xarray.Dataset, levels: Mapping[str, Any]) -> xarray.Dataset:
    """With one dimension per axis instead of that of the runs."""
    shape = tuple(map(len, levels.values()))
    told = {name: made[name].attrs for name in levels}
    variables = {name: _fold_runs(one, tuple(levels), shape) for name, one in made.data_vars.items()}
    times = {name: one for name, one in made.coords.items() if RUN not in one.dims}
    coords = {name: (name, values, told[name]) for name, values in levels.items()}
    return xarray.Dataset(variables, {**coords, **times})


def _fold_runs(one: Any, names: tuple[str, ...], shape: tuple[int, ...]) -> Any:
    """Return a variable with its dimension of runs, which is its first, cut into those of the grid."""
    data = one.variable.data
    return (*names, *one.dims[1:]), data.reshape(*shape, *one.shape[1:]), one.attrs


def _describe_request(store: Store) -> dict[str, Any]:
    """Return the request as attributes for netCDF."""
    known = {n: v for n, v in store.spec.items() if n not in PRIVATE and v is not None}
    plain = (str, int, float, list)
    return {n: v if isinstance(v, plain) else json.dumps(v) for n, v in known.items()}
