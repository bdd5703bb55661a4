"""Store of a sweep: a self-contained Zarr group (format 3) that xarray opens.

    run                       one entry per run
    PATH of a varied number   its value in SI, (run,)
    words of a measure        its number in SI, (run,); NaN where the run failed
    OUTPUT                    a trace, (run, time of OUTPUT)
    status                    how the run ended (`martensite.base.status`), (run,)
    ended                     when it ended [s], (run,); NaN where that is not known
    accuracy                  how far it may be off, a share of ranges, (run,); NaN on equal steps
    made                      checksum of the files of a chunk (CRC-32), (chunk,); 0 where it is not there

All arrays are cut at the same runs: a chunk of the sweep is a separate region, which exactly one writer writes. A chunk
is complete when all of it is written and its files match the checksum. The attributes contain the request, with the
scenario, and the metadata of every array. With them a stopped or damaged sweep continues.
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
"""A checksum, as it stands in its file."""
AGAIN = "Give the same `martensite sweep` command again: it makes anew what is damaged."
NUMBER = "f8"
FULL = (errno.ENOSPC, errno.EDQUOT)
"""Error numbers of a full disk or quota."""
MAY_DIFFER = ("folder", "modules", "title")
"""Attributes that may differ: folder and title of the scenario, and modules."""
LONGEST = 60
"""Characters of a value that is shown."""
WORDS = {
    "over": "axes",
    "traces": "traces",
    "chunk": "runs in a chunk",
    "version": "version of martensite",
    "numbers": "numbers in files that the scenario names",
}
STRETCH = 1 << 20
"""Runs that are read at a time where all are looked at."""


def create_store(path: Path, plan: SweepPlan, spec: Mapping[str, Any]) -> Store:
    """Make a store, or open the one that is there if it holds the same sweep.

    The group appears whole or not at all, so that several processes may do this at a time.

    Raises:
        DataError: something else is there, or the folder cannot be written.
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
    """Remove what is there, a file or a folder, as a damaged disk may have put it in place of the other."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _describe_reason(error: OSError) -> str:
    """Why something could not be written."""
    return "the disk is full" if error.errno in FULL else error.strerror or str(error)


def _create_group(path: Path, plan: SweepPlan, spec: Mapping[str, Any]) -> None:
    """An empty group for a plan."""
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
    """Return every array: its numbers, dimensions, (length, length of a chunk) of each, attributes."""
    runs, system = (plan.size, plan.chunk), plan.course.system
    found: dict[str, Any] = {}
    for axis in plan.axes:
        told = {"units": axis.target.unit, "long_name": axis.target.doc, "role": "varied"}
        found[axis.target.name] = NUMBER, (RUN,), [runs], told
    for words, one in plan.measures.items():
        told = {"units": one.unit_in(system), "long_name": words, "role": "measure"}
        found[words] = NUMBER, (RUN,), [runs], told
    for trace in plan.traces:
        along, count = TIME.format(trace.output), len(plan.trace_times(trace))
        found[along] = NUMBER, (along,), [(count, count)], {"units": "s", "role": "time"}
        output = system.outputs()[trace.output]
        told = {"units": output.unit, "long_name": output.long_name, "role": "trace"}
        found[trace.output] = NUMBER, (RUN, along), [runs, (count, count)], told
    for name, (unit, words) in DETAILS.items():
        told = {"units": unit, "long_name": words, "role": "detail"}
        found[name] = NUMBER, (RUN,), [runs], told
    meanings = " ".join(one.name.lower() for one in Status)
    flags = {"flag_values": [int(one) for one in Status], "flag_meanings": meanings}
    found[STATUS] = "i1", (RUN,), [runs], {"role": "status", **flags}
    found[MADE] = FLAG.str, (CHUNK,), [(plan.chunks, 1)], {"role": "made"}
    return found


@dataclass(frozen=True)
class Store:
    """A sweep on disk."""

    path: Path

    @cached_property
    def _root(self) -> Any:
        """Open the Zarr group, after a check only that it is a sweep.

        Raises:
            DataError: it is not a sweep.
        """
        if self.path.is_file():
            raise DataError(f"`{self.path}` is a file, and a sweep is a folder (`martensite sweep` writes one).")
        try:
            found = _load_zarr().open_group(str(self.path), mode="r+")
            json.loads(found.attrs[SPEC])
        except (OSError, KeyError, ValueError) as error:
            raise DataError(f"`{self.path}` holds no sweep ({error}).") from None
        return found

    def require_sweep(self) -> None:
        """Raise `DataError` if it holds no sweep, be it damaged or not."""
        self._root  # noqa: B018

    @cached_property
    def _request(self) -> tuple[str, str]:
        """Return the request and the metadata of arrays, as JSON, if both are sound."""
        known = self._root.attrs.asdict()
        if LAYOUT not in known:
            raise DataError(
                f"`{self.path}` was made without checksums, by an earlier version; use --force to replace it."
            )
        if zlib.crc32((known[SPEC] + known[LAYOUT]).encode()) != known.get(CHECK):
            raise DataError(
                f"What `{self.path}` says of its sweep is damaged (`zarr.json`); use --force to replace it."
            )
        return known[SPEC], known[LAYOUT]

    @cached_property
    def group(self) -> Any:
        """Return the Zarr group.

        Raises:
            DataError: there is none, or it is damaged.
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
        """Metadata of all arrays, and the checksums of times."""
        return json.loads(self._request[1])

    def made(self) -> set[int]:
        """Return the numbers of the chunks that are there."""
        return set(np.flatnonzero(self._read_flags()).tolist())

    def find_damaged(self) -> list[int]:
        """Return the numbers of the chunks whose files are not what was written."""
        flags = self._read_flags()
        return [int(chunk) for chunk in np.flatnonzero(flags) if flags[chunk] != self.digest_chunk(int(chunk))]

    def require_sound(self) -> None:
        """Raise `DataError` if anything is not what was written."""
        self.group  # noqa: B018  # says what of the arrays is damaged
        damaged = self.find_damaged()
        if damaged:
            some = ", ".join(map(str, damaged[:5])) + (" …" if len(damaged) > 5 else "")
            of = f"{len(damaged):,} of {len(self._read_flags()):,} chunks are not what was written (chunk {some})"
            raise DataError(f"`{self.path}` is damaged: {of}. {AGAIN}")

    def restore_arrays(self, plan: SweepPlan) -> None:
        """Write anew what arrays are, and the times of traces, where they are damaged."""
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
        """Remove the chunks whose files are not what was written; their numbers."""
        damaged = self.find_damaged()
        for chunk in damaged:
            for file in (self._flag_file(chunk), *self._list_files(chunk)):
                _remove_path(file)
        return damaged

    def _list_damaged_arrays(self) -> list[str]:
        """Return the names of arrays that are not what they were made as."""
        wrong = [name for name, known in self._layout["arrays"].items() if self._read_metadata(name) != known]
        times = self._layout["times"].items()
        return [*wrong, *(name for name, crc in times if _digest_files([self.path / name / "c" / "0"]) != crc)]

    def _read_metadata(self, name: str) -> Any:
        try:
            return json.loads((self.path / name / METADATA).read_bytes())
        except (OSError, ValueError):
            return None

    def _read_flags(self) -> np.ndarray:
        """Checksums of all chunks, 0 of those that are not there, and one that no file has where it is damaged."""
        count = self._layout["arrays"][MADE]["shape"][0]
        found = np.zeros(count, np.int64)
        for chunk in range(count):
            try:
                flag = self._flag_file(chunk).read_bytes()
            except FileNotFoundError:
                continue
            except IsADirectoryError:
                flag = b""
            found[chunk] = np.frombuffer(flag, FLAG)[0] if len(flag) == FLAG.itemsize else -1
        return found

    def _flag_file(self, chunk: int) -> Path:
        return self.path / MADE / "c" / str(chunk)

    def _list_files(self, chunk: int) -> list[Path]:
        """Return the files of a chunk, one of each array."""
        every = self._layout["arrays"].items()
        along = {name: known["dimension_names"] for name, known in every}
        rows = {name: self.path / name / "c" / str(chunk) for name, dims in along.items() if dims[0] == RUN}
        return [file / "0" if len(along[name]) > 1 else file for name, file in rows.items()]

    def digest_chunk(self, chunk: int) -> int:
        """Checksum of the files of a chunk as they are."""
        return _digest_files(self._list_files(chunk))

    def write(self, chunk: int, rows: range, piece: SweepPiece, names: list[str]) -> None:
        """Put a chunk into its region.

        Raises:
            StoppedError: it could not be written; the sentence says what to do.
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
        """Yield the stretches of runs, and which of them are there: so that a column need not fit."""
        status = self.group[STATUS]
        size, chunk = status.shape[0], status.chunks[0]
        made, stride = self._read_flags() != 0, max(STRETCH // chunk, 1)
        for first in range(0, len(made), stride):
            there = np.repeat(made[first : first + stride], chunk)
            stop = min(first * chunk + len(there), size)
            yield slice(first * chunk, stop), there[: stop - first * chunk]


def _digest_files(files: Iterable[Path]) -> int:
    """CRC-32 of files with their lengths, never 0; one that is missing is another than an empty one."""
    found = 0
    for file in files:
        data = file.read_bytes() if file.is_file() else None
        found = zlib.crc32(data or b"", zlib.crc32(str(None if data is None else len(data)).encode(), found))
    return found or 1


def list_differences(there: Mapping[str, Any], here: Mapping[str, Any]) -> list[str]:
    """Return the words for everything that is not the same in two specifications of a sweep.

    The scenario stands for its numbers: where its text differs, they are not named as well.
    """
    known = json.loads(json.dumps(dict(here)))
    names = [n for n in dict.fromkeys((*known, *there)) if n not in MAY_DIFFER]
    apart = [name for name in names if known.get(name) != there.get(name)]
    if "scenario" in apart and "numbers" in apart:
        apart.remove("numbers")
    return [_describe_difference(name, there.get(name), known.get(name)) for name in apart]


def _describe_difference(name: str, there: Any, here: Any) -> str:
    """Return one difference, with both values if they are short."""
    if name == "scenario":
        there, here = _find_changed_lines(str(there), str(here))
    label = WORDS.get(name, name)
    both = [one if isinstance(one, str) else json.dumps(one) for one in (there, here)]
    if name == "numbers" or max(map(len, both)) > LONGEST:
        return f"{label} differ" if name in WORDS else f"{label} differs"
    return f"{label} `{both[0]}` there, `{both[1]}` here"


def _find_changed_lines(there: str, here: str) -> tuple[str, str]:
    """Return the first lines of two texts that are not the same."""
    pairs = zip_longest(there.splitlines(), here.splitlines(), fillvalue="")
    return next(((a.strip(), b.strip()) for a, b in pairs if a.strip() != b.strip()), ("", ""))


def _load_zarr() -> Any:
    """Import Zarr when a store is opened: it takes a second."""
    import zarr

    return zarr
