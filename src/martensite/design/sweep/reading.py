"""Opening a sweep: what is in its store, as columns with one number per run.

A chunk that is not made has no numbers, and its runs the status `NOT_MADE` (-1).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.design.sweep.axes import SweepAxis, parse_axis
from martensite.design.sweep.store import STATUS, Store
from martensite.design.sweep.table import NOT_MADE, SweepColumn, SweepTable
from martensite.search.free_numbers import Target


def read_sweep(path: Path | str) -> SweepTable:
    """The runs of a sweep, as far as they are made.

    Args:
        path: its Zarr store; it may still be written.

    Raises:
        DataError: it holds no sweep.
        InputError: Zarr is not installed.
    """
    store = Store(Path(path))
    status = read_status(store)
    axes = read_axes(store)
    gone = status == NOT_MADE
    names = [one.target.name for one in axes]
    logs = {one.target.name: one.log for one in axes}
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
    """Status of every run; `NOT_MADE` where its chunk is not there."""
    status = np.asarray(store.group[STATUS][:], np.int8)
    places = np.arange(len(status)) // int(store.spec["chunk"])
    return np.where(np.isin(places, list(store.made())), status, np.int8(NOT_MADE))


def read_axes(store: Store) -> list[SweepAxis]:
    """Axes in the order in which they were asked for; of a normal one only the kind is to be used.

    The scenario is not read again: it may need parts of the user's own.
    """
    targets = {
        str(name): Target(str(name), str(name), array.attrs["units"], 1.0)
        for name, array in store.group.arrays()
        if array.attrs.get("role") == "varied"
    }
    return [parse_axis(words, targets) for words in store.spec["over"]]


def read_levels(store: Store, axes: list[SweepAxis]) -> tuple[Any, ...] | None:
    """Levels of every axis of a grid; None of other designs."""
    if store.spec["sample"].strip() != "grid":
        return None
    return tuple(one.levels() for one in axes)


def _read_column(store: Store, name: str, gone: NDArray[np.bool_], log: bool) -> SweepColumn:
    array = store.group[name]
    values = np.where(gone, np.nan, np.asarray(array[:], float))
    return SweepColumn(name, str(array.attrs["units"]), values, log)
