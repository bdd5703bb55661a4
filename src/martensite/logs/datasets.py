"""Published measurements, listed with licence and SHA-256, in the package or downloaded from their authors.

Small sets with a suitable licence are in the package. `fetch_dataset` downloads a data set into the user's cache (or
into $MARTENSITE_DATA if set). No file with another SHA-256 is stored or read. Manual copies are $MARTENSITE_DATA/<data
set>/<file>.
"""

from __future__ import annotations

import hashlib
import os
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from http.client import HTTPException
from pathlib import Path
from typing import Any
from urllib.error import HTTPError
from urllib.parse import quote
from urllib.request import urlopen

from martensite.base.caches import cache_folder, require_cache
from martensite.base.errors import DataError, require_known
from martensite.base.files import MOST_LOG, make_folder, read_unpacked, write_file
from martensite.logs.layout import Layout

VARIABLE = "MARTENSITE_DATA"
TIMEOUT = 30.0
"""Timeout of a server [s]."""
_LISTED = Path(__file__).parent / "data"


@dataclass(frozen=True)
class DataFile:
    """One file of a data set."""

    name: str
    upstream: str
    """Name of the file in the original source, relative to the address of the set; empty if unknown."""
    sha256: str
    layout: Layout


@dataclass(frozen=True)
class DataSet:
    """Series of measurements with source and licence."""

    name: str
    title: str
    summary: str
    caution: str
    """Limits of the data: claims that they do not support."""
    licence: str
    notice: str
    """Copyright notice, required with copies."""
    cite: str
    """Key in the bibliography."""
    page: str
    """Web page of the files."""
    base: str
    """Base address of the files."""
    files: dict[str, DataFile]

    @property
    def packaged(self) -> Path | None:
        """Return the package folder with its `.gz` files and licence; None if it must be downloaded."""
        folder = _LISTED / self.name
        return folder if folder.is_dir() else None


def dataset_names() -> list[str]:
    """Return the names of all data sets."""
    return sorted(path.stem for path in _LISTED.glob("*.toml"))


def describe_dataset(name: str) -> DataSet:
    """Return the listing of a data set.

    Raises:
        UnknownNameError: the data set does not exist.
    """
    require_known("data set", name, dataset_names())
    text = (_LISTED / f"{name}.toml").read_text(encoding="utf-8")
    document: dict[str, Any] = tomllib.loads(text)
    shared: dict[str, Any] = document.pop("layout", {})
    files = {file["name"]: _locate_file(file, shared) for file in document.pop("files")}
    return DataSet(name=name, files=files, **document)


def _locate_file(entry: dict[str, Any], shared: dict[str, Any]) -> DataFile:
    lines: dict[str, Any] = {**shared, **entry.get("layout", {})}
    lines["columns"] = tuple(lines["columns"])
    return DataFile(entry["name"], entry.get("upstream", ""), entry["sha256"], Layout(**lines))


def describe_layout(key: str) -> Layout:
    """Return the layout of the file `<data set>/<file>`."""
    return _find_entry(key)[1].layout


def locate_file(key: str) -> Path:
    """Return the path of the verified local copy of `<data set>/<file>`.

    Raises:
        UnknownNameError: the data set or the file in it does not exist.
        DataError: this machine lacks a copy, or the copy differs from the listed file.
    """
    dataset, file = _find_entry(key)
    path = _find_copy(dataset, file)
    if path is None:
        raise DataError(f"`{key}` is not on this machine; {_describe_remedy(dataset, file)}")
    _verify_file(path, dataset, file)
    return path


def is_here(key: str) -> bool:
    """Return whether this machine has a copy of `<data set>/<file>`, verified or not.

    Raises:
        UnknownNameError: the data set or the file in it does not exist.
    """
    return _find_copy(*_find_entry(key)) is not None


def fetch_dataset(name: str, force: bool = False, progress: Callable[[str, int, int], None] | None = None) -> Path:
    """Download the missing files of a data set, and return their folder.

    Args:
        name: data set; packaged sets are downloaded only with `force`.
        force: replace existing files.
        progress: called after each file with its name, its number, and the number of files.

    Raises:
        UnknownNameError: the data set does not exist.
        DataError: a file is not available or differs from the listed file; existing files stay unchanged.
    """
    dataset = describe_dataset(name)
    if dataset.packaged is not None and not force:
        return dataset.packaged
    own = _own_folders(dataset)
    folder = next((f for f in own if f.is_dir()), own[0]) if own else _locate_cache(dataset)
    for number, file in enumerate(dataset.files.values(), start=1):
        path = folder / file.name
        if path.is_file() and not force:
            _verify_file(path, dataset, file)
        else:
            _store_file(path, _download_file(dataset, file))
        if progress is not None:
            progress(file.name, number, len(dataset.files))
    return folder


def _find_entry(key: str) -> tuple[DataSet, DataFile]:
    name, _, file = key.partition("/")
    dataset = describe_dataset(name)
    require_known(f"file of data set `{name}`", file, dataset.files)
    return dataset, dataset.files[file]


def _find_copy(dataset: DataSet, file: DataFile) -> Path | None:
    paths = (folder / file.name for folder in (*_own_folders(dataset), _locate_cache(dataset)))
    packed = [] if dataset.packaged is None else [dataset.packaged / f"{file.name}.gz"]
    return next((path for path in (*paths, *packed) if path.is_file()), None)


def _own_folders(dataset: DataSet) -> list[Path]:
    own = os.environ.get(VARIABLE)
    if not own:
        return []
    return [Path(own) / dataset.name, Path(own) / dataset.name.replace("-", "_")]


def _locate_cache(dataset: DataSet) -> Path:
    return cache_folder() / dataset.name


def _describe_remedy(dataset: DataSet, file: DataFile) -> str:
    by_hand = f"save it as `{dataset.name}/{file.name}` in a folder, and set {VARIABLE} to that folder."
    if file.upstream:
        return f"run `martensite data fetch {dataset.name}`, or {by_hand}"
    return f"its address is not on record: look for it at {dataset.page}, {by_hand}"


def _verify_file(path: Path, dataset: DataSet, file: DataFile) -> None:
    digest = hashlib.sha256(read_unpacked(path, MOST_LOG)).hexdigest()
    if digest != file.sha256:
        raise DataError(
            f"`{path}` is not the file that data set `{dataset.name}` lists: its SHA-256 is {digest[:12]}…, not "
            f"{file.sha256[:12]}…; remove it, or replace it with `martensite data fetch {dataset.name} --force`."
        )


def _download_file(dataset: DataSet, file: DataFile) -> bytes:
    if not file.upstream:
        raise DataError(f"`{file.name}` cannot be fetched; {_describe_remedy(dataset, file)}")
    url = dataset.base + quote(file.upstream)
    try:
        with urlopen(url, timeout=TIMEOUT) as answer:
            content: bytes = answer.read()
    except (OSError, HTTPException) as error:
        reason = f"answer {error.code}" if isinstance(error, HTTPError) else _describe_reason(error)
        raise DataError(
            f"Cannot download {url} ({reason}). Where there is no network, take the file from another machine: save "
            f"it as `{dataset.name}/{file.name}` in a folder, and set {VARIABLE} to that folder."
        ) from None
    digest = hashlib.sha256(content).hexdigest()
    if digest != file.sha256:
        raise DataError(
            f"What {url} holds is not the file that data set `{dataset.name}` lists: its SHA-256 "
            f"is {digest[:12]}…, not {file.sha256[:12]}…; nothing was kept."
        )
    return content


def _describe_reason(error: Exception) -> str:
    return str(getattr(error, "reason", "") or error or type(error).__name__)


def _store_file(path: Path, content: bytes) -> None:
    if path.parent.parent == cache_folder():
        require_cache(path.parent.name)
    else:
        make_folder(path.parent)
    write_file(path, content)
