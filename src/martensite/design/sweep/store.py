"""Store of a sweep: a self-contained Zarr group (format 3) that xarray opens.

    run                       one entry per run
    PATH of a parameter       its value in SI, (run,)
    text of a measure         its value in SI, (run,); NaN for a failed run
    OUTPUT                    a trace, (run, time of OUTPUT)
    status                    end of the run (`martensite.base.status`), (run,)
    ended                     time of the end [s], (run,); NaN if unknown
    accuracy                  error bound as a fraction of ranges, (run,); NaN on equal steps
    made                      checksum of the files of a chunk (CRC-32), (chunk,); 0 for a missing chunk

All arrays have the same chunks, and each chunk has exactly one writer. A chunk is complete when its files match the
checksum. The attributes hold the request with the scenario, and the metadata of every array, from which a stopped or
damaged sweep continues.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from martensite.base.errors import DataError, StoppedError
from martensite.base.interrupts import hold_interrupts
from martensite.base.status import Status
from martensite.design.sweep.plan import DETAILS, SweepPiece, SweepPlan

RUN, CHUNK, MADE, STATUS = "run", "chunk", "made", "status"
TIME = "time of {}"
SPEC, LAYOUT, CHECK = "martensite.design.sweep", "martensite_arrays", "martensite_check"
"""Attributes: the request, the metadata of all arrays, and the checksum of both."""
METADATA = "zarr.json"
FLAG = np.dtype("<u4")
"""Type of a stored checksum."""
AGAIN = "Give the same `martensite sweep` command again: it makes anew what is damaged."
NUMBER = "f8"
FULL = (errno.ENOSPC, errno.EDQUOT)
"""Error numbers of a full disk or quota."""
MAY_DIFFER = ("folder", "modules", "title")
"""Entries of the request that may differ."""
LONGEST = 60
"""Characters of a reported value."""
WORDS = {
    "over": "axes",
    "traces": "traces",
    "chunk": "runs in a chunk",
    "version": "version of martensite",
    "numbers": "numbers in files that the scenario names",
}
STRETCH = 1 << 20
"""Runs that are read at a time."""


def create_store(path: Path, plan: SweepPlan, spec: Mapping[str, Any]) -> Store:
    """Create a store, or open an existing store of the same sweep.

    The group appears whole or not at all, so several processes may create it.

    Raises:
        DataError: the path holds something else, or the folder cannot be written.
        StoppedError: the disk is full.
    """
    if not path.exists():
        part = path.with_name(f".{path.name}.{os.urandom(4).hex()}.part")
        try:
            with hold_interrupts():
                _create_group(part, plan, spec)
                part.rename(path)
        except OSError as error:
            if not path.exists():  # not made meanwhile by another process
                kind = StoppedError if error.errno in FULL else DataError
                raise kind(f"`{path}` could not be made: {_describe_reason(error)}.") from None
        finally:
            shutil.rmtree(part, ignore_errors=True)
    store = Store(path)
    apart = list_differences(store.spec, spec)
    if apart:
        raise DataError(
            f"`{path}` holds another sweep: {'; '.join(apart)}. Choose another --out, or use --force to replace it."
        )
    store.restore_arrays(plan)
    return store


def _remove_path(path: Path) -> None:
    """Remove a file or a folder."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _describe_reason(error: OSError) -> str:
    """Return the reason for a failed write."""
    return "the disk is full" if error.errno in FULL else error.strerror or str(error)


def _create_group(path: Path, plan: SweepPlan, spec: Mapping[str, Any]) -> None:
    """Create an empty group for a plan."""
    group = _load_zarr().create_group(str(path), attributes={SPEC: json.dumps(dict(spec))})
    for name, (kind, dims, sizes, attributes) in _lay_out_arrays(plan).items():
        shape, chunks = zip(*sizes, strict=True)
        group.create_array(
            name,
            shape=shape,
            chunks=chunks,
            dtype=kind,
            dimension_names=dims,
            fill_value=np.nan if kind == NUMBER else 0,
            attributes=attributes,
            compressors="auto" if RUN in dims else None,  # what is repaired is the same to the last bit
        )
    for trace in plan.traces:
        group[TIME.format(trace.output)][:] = plan.trace_times(trace)
    arrays = {name: json.loads((path / name / METADATA).read_text()) for name in sorted(group.array_keys())}
    times = {
        name: _digest_files([path / name / "c" / "0"]) for name in (TIME.format(one.output) for one in plan.traces)
    }
    layout = json.dumps({"arrays": arrays, "times": times})
    group.attrs.update({LAYOUT: layout, CHECK: zlib.crc32((group.attrs[SPEC] + layout).encode())})


def _lay_out_arrays(plan: SweepPlan) -> dict[str, tuple[str, tuple[str, ...], list[tuple[int, int]], Any]]:
    """Return number type, dimensions, (length, chunk length) of each dimension, and attributes of every array."""
    runs, system = (plan.size, plan.chunk), plan.course.system
    arrays: dict[str, Any] = {}
    for axis in plan.axes:
        attributes = {"units": axis.target.unit, "long_name": axis.target.doc, "role": "varied"}
        arrays[axis.target.name] = NUMBER, (RUN,), [runs], attributes
    for words, one in plan.measures.items():
        attributes = {"units": one.unit_in(system), "long_name": words, "role": "measure"}
        arrays[words] = NUMBER, (RUN,), [runs], attributes
    for trace in plan.traces:
        along, count = TIME.format(trace.output), len(plan.trace_times(trace))
        arrays[along] = NUMBER, (along,), [(count, count)], {"units": "s", "role": "time"}
        output = system.outputs()[trace.output]
        attributes = {"units": output.unit, "long_name": output.long_name, "role": "trace"}
        arrays[trace.output] = NUMBER, (RUN, along), [runs, (count, count)], attributes
    for name, (unit, words) in DETAILS.items():
        arrays[name] = NUMBER, (RUN,), [runs], {"units": unit, "long_name": words, "role": "detail"}
    meanings = " ".join(one.name.lower() for one in Status)
    flags = {"flag_values": [int(one) for one in Status], "flag_meanings": meanings}
    arrays[STATUS] = "i1", (RUN,), [runs], {"role": "status", **flags}
    arrays[MADE] = FLAG.str, (CHUNK,), [(plan.chunks, 1)], {"role": "made"}
    return arrays


@dataclass(frozen=True)
class Store:
    """Sweep on disk."""

    path: Path

    @cached_property
    def _root(self) -> Any:
        """Return the Zarr group, after a check that it is a sweep.

        Raises:
            DataError: it is not a sweep.
        """
        if self.path.is_file():
            raise DataError(f"`{self.path}` is a file, and a sweep is a folder (`martensite sweep` writes one).")
        try:
            root = _load_zarr().open_group(str(self.path), mode="r+")
            json.loads(root.attrs[SPEC])
        except (OSError, KeyError, ValueError) as error:
            raise DataError(f"`{self.path}` holds no sweep ({error}).") from None
        return root

    def require_sweep(self) -> None:
        """Raise `DataError` if the path holds no sweep."""
        self._root  # noqa: B018

    @cached_property
    def _request(self) -> tuple[str, str]:
        """Return the request and the metadata of arrays as JSON, after a check of both."""
        attributes = self._root.attrs.asdict()
        if LAYOUT not in attributes:
            raise DataError(
                f"`{self.path}` was made without checksums, by an earlier version; use --force to replace it."
            )
        if zlib.crc32((attributes[SPEC] + attributes[LAYOUT]).encode()) != attributes.get(CHECK):
            raise DataError(
                f"What `{self.path}` says of its sweep is damaged (`zarr.json`); use --force to replace it."
            )
        return attributes[SPEC], attributes[LAYOUT]

    @cached_property
    def group(self) -> Any:
        """Return the Zarr group.

        Raises:
            DataError: it does not exist or is damaged.
        """
        damaged = self._list_damaged_arrays()
        if damaged:
            raise DataError(f"`{self.path}` is damaged: {', '.join(f'`{name}`' for name in damaged)}. {AGAIN}")
        return self._root

    @property
    def spec(self) -> dict[str, Any]:
        """Return the request."""
        return json.loads(self._request[0])

    @cached_property
    def _layout(self) -> dict[str, dict[str, Any]]:
        """Return the metadata of all arrays, and the checksums of times."""
        return json.loads(self._request[1])

    def list_finished_chunks(self) -> set[int]:
        """Return the numbers of the finished chunks."""
        return set(np.flatnonzero(self._read_flags()).tolist())

    def find_damaged(self) -> list[int]:
        """Return the numbers of the chunks with damaged files."""
        flags = self._read_flags()
        return [int(chunk) for chunk in np.flatnonzero(flags) if flags[chunk] != self.digest_chunk(int(chunk))]

    def require_sound(self) -> None:
        """Raise `DataError` if an array or chunk is damaged."""
        self.group  # noqa: B018  # says what of the arrays is damaged
        damaged = self.find_damaged()
        if damaged:
            some = ", ".join(map(str, damaged[:5])) + (" …" if len(damaged) > 5 else "")
            of = f"{len(damaged):,} of {len(self._read_flags()):,} chunks are not what was written (chunk {some})"
            raise DataError(f"`{self.path}` is damaged: {of}. {AGAIN}")

    def restore_arrays(self, plan: SweepPlan) -> None:
        """Restore damaged metadata of arrays, and times of traces."""
        for name in self._list_damaged_arrays():
            folder = self.path / name
            if not folder.is_dir():
                _remove_path(folder)
            folder.mkdir(exist_ok=True)
            _remove_path(folder / METADATA)
            (folder / METADATA).write_text(json.dumps(self._layout["arrays"][name]))
            for trace in plan.traces:
                if name == TIME.format(trace.output):
                    _remove_path(folder / "c")
                    self._root[name][:] = plan.trace_times(trace)

    def discard_damaged(self) -> list[int]:
        """Remove the damaged chunks, and return their numbers."""
        damaged = self.find_damaged()
        for chunk in damaged:
            for file in (self._flag_file(chunk), *self._list_files(chunk)):
                _remove_path(file)
        return damaged

    def _list_damaged_arrays(self) -> list[str]:
        """Return the names of arrays with damaged metadata or times."""
        wrong = [name for name, right in self._layout["arrays"].items() if self._read_metadata(name) != right]
        times = self._layout["times"].items()
        return [*wrong, *(name for name, crc in times if _digest_files([self.path / name / "c" / "0"]) != crc)]

    def _read_metadata(self, name: str) -> Any:
        try:
            return json.loads((self.path / name / METADATA).read_bytes())
        except (OSError, ValueError):
            return None

    def _read_flags(self) -> np.ndarray:
        """Return the checksums of all chunks; 0 for a missing chunk, -1 for a damaged checksum."""
        count = self._layout["arrays"][MADE]["shape"][0]
        flags = np.zeros(count, np.int64)
        for chunk in range(count):
            try:
                flag = self._flag_file(chunk).read_bytes()
            except FileNotFoundError:
                continue
            except IsADirectoryError:
                flag = b""
            flags[chunk] = np.frombuffer(flag, FLAG)[0] if len(flag) == FLAG.itemsize else -1
        return flags

    def _flag_file(self, chunk: int) -> Path:
        return self.path / MADE / "c" / str(chunk)

    def _list_files(self, chunk: int) -> list[Path]:
        """Return the files of a chunk, one of each array."""
        every = self._layout["arrays"].items()
        along = {name: one["dimension_names"] for name, one in every}
        rows = {name: self.path / name / "c" / str(chunk) for name, dims in along.items() if dims[0] == RUN}
        return [file / "0" if len(along[name]) > 1 else file for name, file in rows.items()]

    def digest_chunk(self, chunk: int) -> int:
        """Return the checksum of the files of a chunk."""
        return _digest_files(self._list_files(chunk))

    def write(self, chunk: int, rows: range, piece: SweepPiece, names: list[str]) -> None:
        """Write a chunk into its region.

        Raises:
            StoppedError: it could not be written; the message has a remedy.
        """
        region = slice(rows.start, rows.stop)
        columns = dict(zip(names, piece.values.T, strict=True)) | piece.scalars | piece.traces
        try:
            with hold_interrupts():
                for name, values in (columns | {STATUS: piece.status}).items():
                    self.group[name][region] = values
                self.group[MADE][chunk] = self.digest_chunk(chunk)
        except OSError as error:
            raise StoppedError(
                f"Chunk {chunk} of `{self.path}` could not be written: {_describe_reason(error)}. "
                "What was written before is kept; mend this and give the same command again: it "
                "goes on from there."
            ) from None

    def stretches(self) -> Iterator[tuple[slice, np.ndarray]]:
        """Yield ranges of runs and true for each finished run, so that a column need not fit into memory."""
        status = self.group[STATUS]
        size, chunk = status.shape[0], status.chunks[0]
        flags, stride = self._read_flags() != 0, max(STRETCH // chunk, 1)
        for first in range(0, len(flags), stride):
            there = np.repeat(flags[first : first + stride], chunk)
            stop = min(first * chunk + len(there), size)
            yield slice(first * chunk, stop), there[: stop - first * chunk]


def _digest_files(files: Iterable[Path]) -> int:
    """Return the CRC-32 of files with their lengths, never 0; a missing file differs from an empty one."""
    checksum = 0
    for file in files:
        data = file.read_bytes() if file.is_file() else None
        checksum = zlib.crc32(data or b"", zlib.crc32(str(None if data is None else len(data)).encode(), checksum))
    return checksum or 1


def list_differences(there: Mapping[str, Any], here: Mapping[str, Any]) -> list[str]:
    """Return sentences on the differences of two specifications of a sweep.

    Changed numbers are not listed beside a changed scenario.
    """
    plain = json.loads(json.dumps(dict(here)))
    names = [n for n in dict.fromkeys((*plain, *there)) if n not in MAY_DIFFER]
    apart = [name for name in names if plain.get(name) != there.get(name)]
    if "scenario" in apart and "numbers" in apart:
        apart.remove("numbers")
    return [_describe_difference(name, there.get(name), plain.get(name)) for name in apart]


def _describe_difference(name: str, there: Any, here: Any) -> str:
    """Return a difference, with both values if they are short."""
    if name == "scenario":
        there, here = _find_changed_lines(str(there), str(here))
    label = WORDS.get(name, name)
    both = [one if isinstance(one, str) else json.dumps(one) for one in (there, here)]
    if name == "numbers" or max(map(len, both)) > LONGEST:
        return f"{label} differ" if name in WORDS else f"{label} differs"
    return f"{label} `{both[0]}` there, `{both[1]}` here"


def _find_changed_lines(there: str, here: str) -> tuple[str, str]:
    """Return the first different lines of two texts."""
    pairs = zip_longest(there.splitlines(), here.splitlines(), fillvalue="")
    return next(((a.strip(), b.strip()) for a, b in pairs if a.strip() != b.strip()), ("", ""))


def _load_zarr() -> Any:
    """Import Zarr, which takes a second."""
    import zarr

    return zarr
