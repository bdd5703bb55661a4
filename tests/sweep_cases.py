"""Sweeps of a thin wire that take a moment, and a job without physics that can be made to fail."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from one_wire import THIN_WIRE

from martensite.base.status import Status
from martensite.design.sweep.api import Progress, SweepExecution, begin_sweep, run_chunks
from martensite.design.sweep.backends.base import AbstractBackend, Report
from martensite.design.sweep.job import SweepJob, SweepRequest
from martensite.design.sweep.plan import SweepPiece
from martensite.scenario.scenario import Scenario, read_scenario

WIRE = (
    THIN_WIRE
    + """
[drive]
kind = "voltage"
waveform = { kind = "step", high = "3 V", at = "0.1 s", until = "1.3 s" }

[run]
duration = "2 s"
samples = 11
step = "0.1 s"
"""
)
OVER = "diameter=0.12..0.2 mm:3", "high=2..4 V:4"
AXES = tuple(word for axis in OVER for word in ("--over", axis))


def wire(text: str = WIRE, **changed: Any) -> Scenario:
    """The wire, with values by path (`__` for a dot) replaced."""
    return read_scenario(text, overrides={k.replace("__", "."): v for k, v in changed.items()})


def wanted(*over: str, **more: Any) -> SweepRequest:
    """A small grid on plain floats, in chunks of 3."""
    known: dict[str, Any] = {"chunk": 3, "runtime": "floats"}
    return SweepRequest(over=over or OVER, **(known | more))


def arrays(path: Path) -> Iterator[tuple[str, bytes]]:
    """Names and bytes of all arrays of a store."""
    import zarr

    group: Any = zarr.open_group(str(path), mode="r")
    for name in sorted(group.array_keys()):
        yield name, group[name][...].tobytes()


class Poison(ValueError):
    """What a failing run raises."""


@dataclass(frozen=True)
class Doubling(SweepJob):
    """A job whose runs double their number; some kill their process, some raise an error."""

    spec: str = ""
    size: int = 24
    chunk: int = 4
    deadly: tuple[int, ...] = ()
    failing: tuple[int, ...] = ()
    once: bool = False
    """Kill the first process only."""
    error: Exception = field(default_factory=lambda: Poison("no"))

    @property
    def chunks(self) -> range:
        return range(-(-self.size // self.chunk))

    def __call__(self, chunk: int) -> Report:
        return self.store(chunk, self.compute(self.rows(chunk)))

    def rows(self, chunk: int) -> range:
        return range(chunk * self.chunk, min((chunk + 1) * self.chunk, self.size))

    def compute(self, rows: range) -> SweepPiece:
        if set(self.deadly) & set(rows):
            mark = self.path / "dead"
            if not (self.once and mark.exists()):
                mark.touch()
                os._exit(9)
        if set(self.failing) & set(rows):
            raise self.error
        return self.piece(rows, 2.0 * np.array(rows), Status.OK)

    def make_lost_piece(self, rows: range) -> SweepPiece:
        return self.piece(rows, np.full(len(rows), np.nan), Status.LOST)

    @staticmethod
    def piece(rows: range, found: np.ndarray, status: Status) -> SweepPiece:
        numbers = np.array(rows, float)[:, None]
        return SweepPiece(numbers, {"double": found}, {}, np.full(len(rows), status, np.int8))

    def store(self, chunk: int, piece: SweepPiece, remarks: tuple[str, ...] = ()) -> Report:
        np.save(self.path / f"{chunk}.npy", piece.scalars["double"])
        return Report(chunk, dict(Counter(piece.status.tolist())), remarks=remarks)

    def stored(self) -> list[float]:
        """All numbers, in order."""
        return np.concatenate([np.load(self.path / f"{c}.npy") for c in self.chunks]).tolist()

    def expected(self) -> list[float]:
        """What undisturbed runs give, and NaN for lost ones."""
        gone = () if self.once else (*self.deadly, *self.failing)
        return [np.nan if k in gone else 2.0 * k for k in range(self.size)]


def ran(backend: AbstractBackend, job: Doubling) -> Progress:
    """All chunks of a job, whose numbers must then be as expected."""
    found = run_chunks(job, job.chunks, set(), backend)
    np.testing.assert_array_equal(job.stored(), job.expected())
    return found


def undisturbed(path: Path, *over: str, **more: Any) -> dict[str, bytes]:
    """Arrays of a sweep of the wire that is made in one go."""
    begin_sweep(wire(), wanted(*over, **more), path, SweepExecution("serial")).run()
    return dict(arrays(path))
