"""The sweeps of a server: stores in its folder, by generated keys.

A name from outside is never a path: a store is found by its key, and its folder contains a cleaned title.
"""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from martensite.app.messages import JsonTable, Request, require_entry
from martensite.app.uploads import is_key, make_key
from martensite.base.errors import DataError, MartensiteError
from martensite.design.sweep.store import STATUS, Store

STORES = "sweeps"
LONGEST_SLUG = 40
_STORE = re.compile(r"^[a-z0-9-]+-([0-9a-f]{16})\.zarr$")


def make_slug(title: str) -> str:
    """Return lower-case letters, digits and dashes of a title."""
    short = re.sub(r"[^a-z0-9]+", "-", title.lower())[:LONGEST_SLUG].strip("-")
    return short or "sweep"


@dataclass(frozen=True)
class SweepFolder:
    """Stores of sweeps by key."""

    folder: Path
    """Folder of the server."""

    @property
    def place(self) -> Path:
        """Return the folder of the stores."""
        return self.folder / STORES

    def new(self, title: str) -> tuple[str, Path]:
        """Return a new key and the path of its future store."""
        key = make_key()
        self.place.mkdir(parents=True, exist_ok=True)
        return key, self.place / f"{make_slug(title)}-{key}.zarr"

    def path(self, key: str) -> Path:
        """Return the store of a key."""
        stores = sorted(self.place.glob(f"*-{key}.zarr")) if is_key(key) else []
        if len(stores) != 1:
            raise DataError("There is no such sweep in this folder; it may have been deleted.")
        return stores[0]

    def all(self) -> dict[str, Path]:
        """Return all stores, the newest first."""
        if not self.place.is_dir():
            return {}
        stores = {m[1]: p for p in self.place.iterdir() if (m := _STORE.match(p.name))}
        return dict(sorted(stores.items(), key=lambda one: -one[1].stat().st_mtime))

    def delete(self, key: str) -> None:
        """Remove a store."""
        path = self.path(key)
        with hold_store(path):
            trash = path.with_name(f".{path.name}.gone")
            path.rename(trash)
        shutil.rmtree(trash)


def find_store(request: Request, folder: Path) -> Path:
    """Return the store of the `key` of a request."""
    return SweepFolder(folder).path(require_entry(request, "key", str))


@contextmanager
def hold_store(path: Path) -> Iterator[None]:
    """Lock a store while it is written, until the process ends.

    Systems without such locks, such as Windows, do not lock.
    """
    if find_spec("fcntl") is None:
        yield
        return
    locks: Any = import_module("fcntl")
    handle = os.open(path, os.O_RDONLY)
    try:
        locks.flock(handle, locks.LOCK_EX | locks.LOCK_NB)
    except OSError:
        os.close(handle)
        raise DataError("This sweep is running already; wait for it, or cancel it.") from None
    try:
        yield
    finally:
        os.close(handle)


def is_busy(path: Path) -> bool:
    """Return whether a store is being written."""
    try:
        with hold_store(path):
            return False
    except DataError:
        return True


def measure_bytes(path: Path) -> int:
    """Return the size of a store on disk [B]."""
    return sum(one.stat().st_size for one in path.rglob("*") if one.is_file())


def summarise_store(key: str, path: Path) -> JsonTable:
    """Return a summary of a sweep: `state` is running, done, stopped or unreadable."""
    table = {"key": key, "path": str(path), "bytes": measure_bytes(path), "made": path.stat().st_mtime}
    try:
        store = Store(path)
        spec, runs = store.spec, int(store.group[STATUS].shape[0])
        chunks, length = store.list_finished_chunks(), int(spec["chunk"])
        done = sum(min(length, runs - chunk * length) for chunk in chunks)
    except (MartensiteError, KeyError, ValueError) as error:
        lost = {"title": path.name, "over": [], "sample": "", "runs": 0, "done": 0}
        return {**table, **lost, "state": "unreadable", "why": str(error)}
    state = "done" if done == runs else "running" if is_busy(path) else "stopped"
    return {
        **table,
        "title": spec["title"],
        "over": spec["over"],
        "sample": spec["sample"],
        "runs": runs,
        "done": done,
        "state": state,
        "why": "",
    }
