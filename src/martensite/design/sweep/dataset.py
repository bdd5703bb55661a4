"""A sweep as an xarray dataset, read when it is needed.

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
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from martensite.base.lazy import import_extra
from martensite.base.status import Status
from martensite.design.sweep.plan import DETAILS
from martensite.design.sweep.reading import read_axes, read_levels, read_status
from martensite.design.sweep.store import RUN, STATUS, Store
from martensite.design.sweep.table import NOT_MADE

if TYPE_CHECKING:
    import xarray

PRIVATE = ("folder", "modules", "chunk", "traces")
"""What was asked for that means nothing elsewhere, or that the variables say."""


def open_sweep(path: Path | str, grid: bool = True) -> xarray.Dataset:
    """Open the store of a sweep.

    Args:
        path: the Zarr group.
        grid: make the axes of a grid dimensions; otherwise, and for samples, there is one
            dimension `run`.

    Raises:
        DataError: there is no sweep.
        InputError: Zarr or xarray is not installed.
    """
    xarray, store = import_extra("xarray", "sweep"), Store(Path(path))
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
    """A variable with its dimension of runs, which is its first, cut into those of the grid."""
    data = one.variable.data
    return (*names, *one.dims[1:]), data.reshape(*shape, *one.shape[1:]), one.attrs


def _describe_request(store: Store) -> dict[str, Any]:
    """What was asked for, as attributes that netCDF can hold."""
    known = {n: v for n, v in store.spec.items() if n not in PRIVATE and v is not None}
    plain = (str, int, float, list)
    return {n: v if isinstance(v, plain) else json.dumps(v) for n, v in known.items()}
