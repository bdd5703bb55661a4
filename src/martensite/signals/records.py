"""Records: named columns over time in SI units, measured or computed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from martensite.base.errors import DataError, suggest_name
from martensite.base.formats import write_quantity
from martensite.base.summary import DataTable, Summary
from martensite.signals.table import Table


@dataclass(frozen=True)
class Record:
    """Columns of equal length, including `time` [s]."""

    name: str
    columns: dict[str, list[float]]
    """One list per column, in SI units."""
    units: dict[str, str]
    """SI unit of each column."""
    source: Path | None = None
    """Source file."""
    dropped: int = 0
    """Number of unreadable rows that were skipped."""
    interval: float | None = None
    """Assumed sample time [s] if the file has no time; else None."""

    def __post_init__(self) -> None:
        lengths = {name: len(column) for name, column in self.columns.items()}
        if "time" not in lengths:
            raise DataError(f"Record `{self.name}` needs a column `time` [s].")
        if set(lengths) != set(self.units):
            raise DataError(f"Record `{self.name}` needs one unit for each of its columns.")
        wrong = next((name for name, n in lengths.items() if n != lengths["time"]), None)
        if wrong is not None:
            raise DataError(
                f"Columns of record `{self.name}` must be equally long, but `{wrong}` holds "
                f"{lengths[wrong]} numbers and `time` {lengths['time']}."
            )
        if not lengths["time"]:
            raise DataError(f"Record `{self.name}` holds no rows.")

    def __getitem__(self, name: str) -> list[float]:
        """Return a column by name, in SI.

        Raises:
            DataError: there is no such column.
        """
        if name not in self.columns:
            raise DataError(f"Record `{self.name}` has no column `{name}`. {suggest_name(name, self.columns)}")
        return self.columns[name]

    def summary(self) -> Summary:
        """Return the number of rows, their times, and the range of each column."""
        ends = {name: _find_ends(column) for name, column in self.columns.items()}
        units = self.units
        rows = [(f"`{n}`", *(write_quantity(end, units[n]) for end in pair)) for n, pair in ends.items() if n != "time"]
        lead = f"Record `{self.name}`: {len(self)} rows from {self.times[0]:.6g} to {self.times[-1]:.6g} s"
        data = {n: {"lowest": low, "highest": high, "unit": units[n]} for n, (low, high) in ends.items()}
        return Summary("", [DataTable(("column", "lowest", "highest"), rows, right=(1, 2))], data, lead)

    def __repr__(self) -> str:
        return self.summary().brief()

    def _repr_html_(self) -> str:
        return self.summary()._repr_html_()  # pyright: ignore[reportPrivateUsage]

    @property
    def times(self) -> list[float]:
        """Return the times of the rows [s]."""
        return self.columns["time"]

    def __len__(self) -> int:
        return len(self.times)


def _find_ends(column: Sequence[float]) -> tuple[float, float]:
    """Return the smallest and largest value; NaN without values."""
    values = [one for one in column if not math.isnan(one)] or [math.nan]
    return min(values), max(values)


def out_of_order(times: list[float]) -> int | None:
    """Return the index of the first time that is not above its predecessor; None if all increase."""
    pairs = enumerate(pairwise(times), start=1)
    return next((i for i, (before, time) in pairs if not time > before), None)


def not_finite(numbers: list[float]) -> int | None:
    """Return the index of the first NaN or infinite number; None if all are finite."""
    return next((i for i, number in enumerate(numbers) if not math.isfinite(number)), None)


def table_waveform(record: Record, column: str) -> Table:
    """Return the waveform of a record column: linear between rows, constant outside.

    Raises:
        DataError: the record has no such column.
        ParameterError: the record has only one row, or its times do not increase.
    """
    return Table(times=tuple(record.times), values=tuple(record[column]))
