"""The result of a simulation: sampled columns in SI units, with status and accuracy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from martensite import units
from martensite.errors import SolveError
from martensite.mechanisms.base import Output
from martensite.simulate.alarms import Alarm
from martensite.simulate.balance import HeatBalance, WorkBalance
from martensite.simulate.provenance import NOT_TRIED, tell_conformance
from martensite.status import Status
from martensite.system import PROFILES


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
    """One list per cell and quantity named in `martensite.system.PROFILES`, in SI units; empty
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
        """A column by name, or the times."""
        return self.times if name == "time" else self.columns[name]

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
        return max(self[name]) - min(self[name])

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
        unit = self.unit(name)
        shown = units.readable(unit)
        low, high = (units.from_si(f(self[name]), shown, unit) for f in (min, max))
        label = "" if shown == "1" else f" {shown}"
        return f"{self.outputs[name].long_name} {low:.4g} to {high:.4g}{label}"


def profiles_of(first: int, rows: Sequence[Sequence[float]]) -> dict[str, list[list[float]]]:
    """The profiles among rows; they start at column `first`."""
    cells = (len(rows[0]) - first) // len(PROFILES)
    starts = {name: first + k * cells for k, name in enumerate(PROFILES)}
    return {
        name: [[row[start + i] for row in rows] for i in range(cells)]
        for name, start in starts.items()
        if cells
    }
