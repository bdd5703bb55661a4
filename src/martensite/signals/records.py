"""Records: named columns over time in SI units, measured or computed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from martensite.base.errors import DataError, suggest_name
from martensite.base.formats import write_quantity
from martensite.base.summary import DataTable, Summary
from martensite.signals.table import Table

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    Column = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Record:
    """Columns of equal length, including `time` [s]."""

    name: str
    columns: dict[str, Any]
    """One array per column, in SI units. Other sequences of numbers are converted; all arrays are read-only."""
    units: dict[str, str]
    """SI unit of each column."""
    source: Path | None = None
    """Source file."""
    dropped: int = 0
    """Number of unreadable rows that were skipped."""
    interval: float | None = None
    """Assumed sample time [s] if the file has no time; else None."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "columns", {name: _freeze(column) for name, column in self.columns.items()})
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

    def __getitem__(self, name: str) -> Column:
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
        return self.summary()._repr_html_()  # pyrefly: ignore[protected-access]

    @property
    def times(self) -> Column:
        """Return the times of the rows [s]."""
        return self.columns["time"]

    def __len__(self) -> int:
        return len(self.times)


def _freeze(column: ArrayLike) -> Column:
    """Return numbers as a read-only array."""
    import numpy as np

    numbers = np.asarray(column, dtype=float).view()
    numbers.flags.writeable = False
    return numbers


def _find_ends(column: Column) -> tuple[float, float]:
    """Return the smallest and largest value; NaN without values."""
    import numpy as np

    return float(np.fmin.reduce(column)), float(np.fmax.reduce(column))


def out_of_order(times: ArrayLike) -> int | None:
    """Return the index of the first time that is not above its predecessor; None if all increase."""
    import numpy as np

    return _find_first(~(np.diff(np.asarray(times, dtype=float)) > 0.0), 1)


def not_finite(numbers: ArrayLike) -> int | None:
    """Return the index of the first NaN or infinite number; None if all are finite."""
    import numpy as np

    return _find_first(~np.isfinite(np.asarray(numbers, dtype=float)), 0)


def _find_first(flags: Any, zero: int) -> int | None:
    """Return the index of the first true flag, counted from `zero`; None if all are false."""
    return int(flags.argmax()) + zero if flags.any() else None


def table_waveform(record: Record, column: str) -> Table:
    """Return the waveform of a record column: linear between rows, constant outside.

    Raises:
        DataError: the record has no such column.
        ParameterError: the record has only one row, or its times do not increase.
    """
    return Table(times=tuple(record.times.tolist()), values=tuple(record[column].tolist()))
