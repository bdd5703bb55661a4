"""Drives of runs in C: segments of waveforms, in a window that moves on or whole."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable, Iterator
from functools import cached_property, lru_cache
from itertools import chain, islice, takewhile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.remember_results import remember
from martensite.signals.base import AbstractWaveform
from martensite.signals.moments import Segment

Numbers = NDArray[np.float64]
FIRST_WINDOW, WINDOW = 256, 65_536
"""Initial and maximum number of stored segments of a drive."""
WHOLE = 4096
"""Number of segments up to which a drive is stored for all runs."""
KEPT = 16
"""Number of durations for which a drive is stored."""


class DriveTable(ctypes.Structure):
    """Segments and tones of a drive, as C reads them."""

    _fields_ = [
        ("count", ctypes.c_long),
        ("tones", ctypes.c_long),
        *((name, ctypes.c_void_p) for name in ("start", "level", "slope", "bend", "amplitude", "rate", "phase")),
        ("fastest", ctypes.c_double),
        ("whole", ctypes.c_long),
    ]


@lru_cache(64)
def _find_table_type(count: int) -> Any:
    """Return the type of a table of drives; ctypes forgets array types that nobody keeps."""
    return DriveTable * count


def make_table(count: int) -> Any:
    """Return an empty table of drives."""
    return _find_table_type(count)()


class DriveWindow:
    """Stored segments of a drive in C."""

    def __init__(self, waveform: AbstractWaveform, until: float, whole: Numbers | None = None) -> None:
        self._coming = iter(()) if whole is not None else _list_segments(waveform, until)
        tones = np.array([tuple(tone) for tone in waveform.tones()]).reshape(-1, 3)
        self._tones = np.ascontiguousarray(tones.T)
        self._fastest = float(tones[:, 1].max()) if len(tones) else 0.0
        self.whole = self._ended = whole is not None
        self._columns = np.empty((4, 0)) if whole is None else whole
        self._size = FIRST_WINDOW

    def extend(self, since: float) -> None:
        """Add segments, and discard segments before `since` [s]."""
        if self._ended:
            return
        place = max(0, int(np.searchsorted(self._columns[0], since, side="right")) - 2)
        more = _tabulate_segments(islice(self._coming, self._size))
        self._ended = more.shape[1] < self._size
        self._size = min(4 * self._size, WINDOW)
        self._columns = np.concatenate([self._columns[:, place:], more], axis=1)

    def extend_to_end(self, most: int) -> int:
        """Store all segments unless there are many more than `most`; return the stored number."""
        self.extend(0.0)
        while not self._ended and self._columns.shape[1] < most:
            self.extend(0.0)
        return self._columns.shape[1]

    def known_until(self) -> float:
        """Return the end time [s] of the stored segments."""
        return np.inf if self._ended else float(self._columns[0, -1])

    @cached_property
    def table(self) -> DriveTable:
        """Return the C structure of a whole drive."""
        table = DriveTable()
        self.fill(table, get_address)
        return table

    def fill(self, into: DriveTable, locate: Callable[[NDArray[Any]], int]) -> None:
        """Write the segments to the C structure."""
        columns, tones = map(locate, self._columns), map(locate, self._tones)
        into.count, into.tones = self._columns.shape[1], self._tones.shape[1]
        into.start, into.level, into.slope, into.bend = columns
        into.amplitude, into.rate, into.phase = tones
        into.fastest, into.whole = self._fastest, int(self._ended)


def get_address(array: Any) -> int:
    """Return the address of an array; 0 if it is empty."""
    return ctypes.addressof(ctypes.c_char.from_buffer(array)) if array.size else 0  # `array.ctypes` is much slower


def _list_segments(waveform: AbstractWaveform, until: float) -> Iterator[Segment]:
    return takewhile(lambda one: one.start <= until, waveform.segments(0.0))


def _tabulate_segments(segments: Iterable[Segment]) -> Numbers:
    """Return starts, levels, slopes and bends of segments, (4, segments)."""
    return np.ascontiguousarray(np.fromiter(chain.from_iterable(segments), float).reshape(-1, 4).T)


@remember
def _list_whole_drives(waveform: AbstractWaveform) -> dict[float, DriveWindow | None]:
    """Return the whole drives of a waveform by their end [s], to be filled; None for too many segments."""
    return {}


def open_drive(waveform: AbstractWaveform, until: float) -> DriveWindow:
    """Return the drive of a waveform up to a time [s]: whole and for all runs, or as a window of its own."""
    kept = _list_whole_drives(waveform)
    if until not in kept:
        row = list(islice(_list_segments(waveform, until), WHOLE + 1))
        if len(kept) == KEPT:
            kept.clear()
        kept[until] = DriveWindow(waveform, until, _tabulate_segments(row)) if len(row) <= WHOLE else None
    return kept.get(until) or DriveWindow(waveform, until)
