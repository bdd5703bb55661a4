"""The result of a simulation: sampled columns in SI units, with status and accuracy."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from importlib import import_module
from textwrap import shorten
from typing import TYPE_CHECKING, Any

from martensite.actuators.assembly import PROFILES
from martensite.actuators.mechanisms.base import Output
from martensite.base import units
from martensite.base.errors import SolveError, UnknownNameError
from martensite.base.status import Status
from martensite.simulate.alarms import Alarm
from martensite.simulate.balance import HeatBalance, WorkBalance
from martensite.simulate.provenance import NOT_TRIED, tell_conformance

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]
    import xarray
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Result:
    """Columns over time, and how far they can be trusted."""

    system: Any
    """What was run: a `System` of one element, or a `Machine` of several."""
    waveform: Any
    """The waveform that drove it, or waveforms by name."""
    times: list[float]
    """Sample times [s]."""
    columns: dict[str, list[float]]
    """One list per output of the system, in SI units."""
    status: Status
    """The worst status of all steps; a failed run has no result but raises."""
    status_time: float | None
    """Start of the first step with the worst status [s], where recorded."""
    steps: int
    step: float
    """Longest step taken [s]."""
    accuracy: float | None = None
    """How far temperatures, martensite fractions, stresses and coordinates may be off, as a share
    of the range of each; None if only one run was made."""
    warnings: list[str] = field(default_factory=list[str])
    """Sentences on exceeded limits, slack, a saturated supply, coarse steps."""
    alarms: list[Alarm] = field(default_factory=list[Alarm])
    """Exceeded limits, slack and a saturated supply, with time, duration and amount."""

    profiles: dict[str, list[list[float]]] = field(default_factory=dict[str, list[list[float]]])
    """One list per cell and quantity named in `martensite.actuators.assembly.PROFILES`, in SI
    units; empty
    for an element that is the same all over."""
    beside: dict[str, Output] = field(default_factory=dict[str, Output])
    """Columns that are no outputs of the system, such as what a controller outside of it wanted."""
    runtime: str = ""
    """What it was computed on: floats, C or JAX; empty if that is not said."""
    rejected: int = 0
    """Steps that were made again, shorter."""
    heat: HeatBalance | None = None
    """Of a run with an error control; None where a temperature is prescribed or an element does not
    say what it holds (`unbalanced` tells), or steps are given."""
    work: WorkBalance | None = None
    """Likewise; None where a mechanism does not say what it holds, or steps are given."""
    unbalanced: list[str] = field(default_factory=list[str])
    """Why there is no balance of heat or work in a run with an error control, in sentences."""
    ripple: float = 0.0
    """Temperature [K] that the mean of a drive over a step leaves out, at most."""

    def __getitem__(self, name: str) -> list[float]:
        """A column by name, or the times, in SI units.

        Raises:
            UnknownNameError: there is no such column.
        """
        if name == "time":
            return self.times
        if name not in self.columns:
            raise UnknownNameError("column", name, self.columns)
        return self.columns[name]

    # ---------------------------------------------------------------- ways out

    def plot(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        records: Iterable[Any] | None = None,
        title: str | None = None,
    ) -> Figure:
        """The standard figure: all quantities over time, and the loops ξ–T, ε–T, σ–ε.

        Args:
            path: file to write as well: png, svg or pdf, replaced whole or not at all.
            records: measured records, drawn over the simulation wherever they have the same
                quantity, with the RMS difference in the legend.
            title: first line of the figure; by default what was simulated.

        Raises:
            DataError: the file cannot be written, or a record holds nothing that can be compared.
        """
        room = import_module("martensite.show.figures.overview")
        if path is not None:
            room.save_figure(self, path, records, title)
        return room.plot_result(self, records, title)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write it as netCDF-4, with units and provenance; replaced whole or not at all.

        Raises:
            DataError: the file cannot be written.
        """
        import_module("martensite.scenario.netcdf").save(self, path)

    def to_xarray(self) -> xarray.Dataset:
        """A dataset over time [s], with units and provenance as attributes."""
        return import_module("martensite.scenario.netcdf").to_dataset(self)

    def to_pandas(self) -> pandas.DataFrame:
        """A table with a row per sample, by time [s]; columns in SI units (`attrs["units"]`)."""
        pandas: Any = import_module("pandas")
        index = pandas.Index(self.times, name="time")
        table = pandas.DataFrame({name: self.columns[name] for name in self.outputs}, index=index)
        table.attrs["units"] = {name: self.unit(name) for name in self.outputs}
        return table

    def summary(self) -> str:
        """How the run went, ranges of what is judged, balances, remarks and warnings."""
        return str(self)

    @property
    def energy(self) -> dict[str, HeatBalance | WorkBalance]:
        """The balances that are known, of `heat` and `work`."""
        both = {"heat": self.heat, "work": self.work}
        return {name: one for name, one in both.items() if one is not None}

    def __repr__(self) -> str:
        """A few lines; all of it is in `summary()`."""
        lines = str(self).splitlines()
        more = [f"… {len(lines) - LINES} lines more in summary()"] if len(lines) > LINES else []
        columns = ", ".join(self.outputs)
        return "\n".join([*lines[:LINES], *more, shorten(f"columns: time, {columns}", 100)])

    def _repr_html_(self) -> str:
        """For a notebook: the summary's first line, ranges of all columns, and warnings."""
        rows = "".join(f"<tr>{''.join(map(_cell, self._range(n)))}</tr>" for n in self.outputs)
        head = "".join(f"<th>{word}</th>" for word in ("column", "lowest", "highest", "unit"))
        rest = "".join(f"<p>{escape(one)}</p>" for one in (*self.balances(), *self.remarks()))
        warned = "".join(f"<p><b>{escape(one)}</b></p>" for one in self.warnings)
        first = escape(str(self).partition("\n")[0])
        return f"<p>{first}</p><table><tr>{head}</tr>{rows}</table>{rest}{warned}"

    def _range(self, name: str) -> tuple[str, str, str, str]:
        """Name, lowest and highest value, and the unit in which they are readable."""
        unit = self.unit(name)
        shown = units.readable(unit)
        low, high = (units.from_si(f(self.columns[name]), shown, unit) for f in (min, max))
        words = self.outputs[name].long_name
        return words, f"{low:.6g}", f"{high:.6g}", "" if shown == "1" else shown

    def require(self) -> Result:
        """Return this result, or raise `SolveError` if the run stopped before its end."""
        if self.status.failed:
            reasons = (words for words in self.warnings if words.startswith("The run stopped"))
            raise SolveError(next(reasons, self.status.sentence))
        return self

    @cached_property
    def outputs(self) -> dict[str, Output]:
        """How every column is called, with its unit."""
        return self.system.outputs() | self.beside

    def unit(self, name: str) -> str:
        """SI unit of a column."""
        return "s" if name == "time" else self.outputs[name].unit

    @property
    def coordinate(self) -> str:
        """Name of the first coordinate of the mechanism: its stroke is that of the system."""
        return next(iter(self.system.mechanism.outputs()))

    def range(self, name: str) -> float:
        """Largest minus smallest value of a column, in SI."""
        column = self[name]
        return max(column) - min(column)

    @property
    def stroke(self) -> float:
        """Largest less smallest value of the first coordinate [m] or [rad]."""
        return self.range(self.coordinate)

    def __str__(self) -> str:
        """A summary of a few lines."""
        accuracy = "not estimated" if self.accuracy is None else f"{self.accuracy:.1e} of range"
        where = {"C": " in C", "": ""}.get(self.runtime, f" on {self.runtime}")
        lines = [
            f"{self.times[-1]:.6g} s in {self.steps} steps of at most {self.step:.3g} s{where}, "
            f"accuracy {accuracy}",
            *(line for name in self.system.judged() for line in [self._line(name)]),
        ]
        return "\n".join([*lines, *self.balances(), *self.remarks(), *self.warnings])

    @property
    def conformance(self) -> dict[str, str]:
        """Parts that are none of this package's -> whether they keep what is promised of them.

        `conforms`, `does not conform`, or `not tried` (`martensite conform FILE` does).
        """
        return tell_conformance([self.system, self.waveform])

    def remarks(self) -> list[str]:
        """What is to be known of parts that are none of this package's, in sentences."""
        remedies = {"conforms": ".", NOT_TRIED: "; `martensite conform FILE` does."}
        return [
            f"Part `{name}` is none of this package's; its promises: {found}"
            f"{remedies.get(found, '; what it computes cannot be trusted.')}"
            for name, found in self.conformance.items()
        ]

    def balances(self) -> list[str]:
        """Those of heat and work, in a line each, and why one is missing."""
        known = [str(one) for one in (self.heat, self.work) if one is not None]
        return known + self.unbalanced

    def _line(self, name: str) -> str:
        """From where to where a column goes, in a readable unit."""
        words, low, high, unit = self._range(name)
        return f"{words} {float(low):.4g} to {float(high):.4g}{unit and ' '}{unit}"


LINES = 6
"""Of the summary in `repr`."""


def _cell(text: str) -> str:
    """A cell of a table in HTML."""
    return f"<td>{escape(text)}</td>"


def profiles_of(first: int, rows: Sequence[Sequence[float]]) -> dict[str, list[list[float]]]:
    """The profiles among rows; they start at column `first`."""
    cells = (len(rows[0]) - first) // len(PROFILES)
    starts = {name: first + k * cells for k, name in enumerate(PROFILES)}
    return {
        name: [[row[start + i] for row in rows] for i in range(cells)]
        for name, start in starts.items()
        if cells
    }
