"""Loops in a testing machine with prescribed temperature, for isobaric and isothermal experiments."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from martensite.characterise.loop_paths import LoopPath, measure_arc, trace_loop
from martensite.fit.experiment_kinds.base import Assumptions
from martensite.fit.experiment_kinds.values import Document, with_column
from martensite.search.quantity_text import format_change
from martensite.signals.records import Record

MOST_ROWS = 2000
"""Largest number of compared rows of a loop; more are averaged along its path."""
CYCLES = 3
"""Number of fitted last cycles of a repeated loop."""
MACHINE = """
title = "{title}"
element = {{ kind = "wire", material = "flexinol-90", diameter = "{wide}", length = "{long}", initial_fraction = {xi} }}
mechanism = {{ kind = "testing-machine", control = "{control}", {size} }}
signals = {{ command = {{ kind = "log", column = "{control}" }} }}
drive = {{ kind = "temperature", waveform = {{ kind = "log" }} }}
run = {{ step = "1e3 s" }}
"""
ROUNDNESS = tuple(f"n_{k}=0.1..1" for k in (1, 2, 3, 4))
SLOPES = ("C_A=2..30 MPa/K", "C_M=2..30 MPa/K")


def read_machine(**entries: object) -> Document:
    """Return the scenario of a testing machine."""
    return tomllib.loads(MACHINE.format(**entries))


def with_law(base: Document, law: Document) -> Document:
    """Return a scenario with another law of its element."""
    return base | {"element": base["element"] | {"law": law}}


def read_loop(record: Record, drive: str, response: str, assumptions: Assumptions) -> Record:
    """Return the compared rows of a loop, with smoothed drive and all turning points.

    Of a loop with many cycles the last are used. Notes describe the changes.

    Args:
        record: record in SI.
        drive: drive column of the loop.
        response: measured column.
        assumptions: receiver of the notes.
    """
    whole = keep_measured(record, (drive, response))
    path = trace_loop(whole[drive])
    if path.scatter:
        assumptions.jitter[record.name] = path.error
        assumptions.sentences.append(
            f"`{drive}` of `{record.name}` scatters by {format_change(path.scatter, record.units[drive], 2)} from row "
            f"to row. It is smoothed along each leg, over at least {path.window} rows."
        )
    first, count = _choose_first(path)
    if first:
        assumptions.sentences.append(
            f"`{record.name}` holds {count} cycles. Cycles {count - CYCLES + 1} to {count} are fitted."
        )
    return reduce_rows(with_column(whole, drive, record.units[drive], path.drive), path, response, first)


def smooth_drive(record: Record, drive: str) -> Record:
    """Return a record with a drive that is smoothed along each leg if it has jitter."""
    return with_column(record, drive, record.units[drive], trace_loop(record[drive]).drive)


def find_column(record: Record, wanted: str, alike: Sequence[str]) -> str:
    """Return the wanted column, or the first other column of its group in a record."""
    return wanted if wanted in record.columns else next(name for name in alike if name in record.columns)


def keep_measured(record: Record, needed: Sequence[str]) -> Record:
    """Return the rows of a record in which all needed columns are finite."""
    rows = np.flatnonzero(np.all([np.isfinite(record[name]) for name in needed], axis=0))
    return replace(record, columns={name: column[rows] for name, column in record.columns.items()})


def reduce_rows(record: Record, path: LoopPath, response: str, first: int = 0) -> Record:
    """Return a record from a row on, in at most about `MOST_ROWS` rows.

    More rows are averaged in pieces of about equal path length; turning points are separate pieces.
    """
    rows = len(record)
    if rows - first <= MOST_ROWS:
        edges = np.arange(first, rows + 1)
    else:
        arc = measure_arc(path, record[response])[first:]
        turns = [row + after for row in path.turns if row >= first for after in (0, 1)]
        edges = np.unique([*(first + np.searchsorted(arc, np.linspace(0.0, arc[-1], MOST_ROWS))), *turns, rows])
    means = {name: np.add.reduceat(x, edges[:-1]) / np.diff(edges) for name, x in record.columns.items()}
    return replace(record, columns=means)


def _choose_first(path: LoopPath) -> tuple[int, int]:
    """Return the first row of the fitted cycles, and the number of all cycles."""
    cycles = path.cycles
    if len(cycles) <= CYCLES or not path.is_repeated:
        return 0, len(cycles)
    return cycles[-CYCLES][0], len(cycles)
