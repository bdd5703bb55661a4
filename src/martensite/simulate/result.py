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
from martensite.status import Status
from martensite.system import PROFILES


@dataclass(frozen=True)
class HeatBalance:
    """Where the heat of a run went; over all elements, in J."""

    put_in: float
    """By the drives."""
    lost: float
    """To the surroundings."""
    stored: float
    """More than in the beginning, as sensible and as latent heat."""

    @property
    def residual(self) -> float:
        """What is not accounted for, as a share of the largest of the three."""
        most = max(abs(self.put_in), abs(self.lost), abs(self.stored))
        missing = abs(self.put_in - self.lost - self.stored)
        return missing / most if most > LEAST_HEAT else 0.0

    def __str__(self) -> str:
        """In a line."""
        return (
            f"heat: {self.put_in:.4g} J put in, {self.lost:.4g} J to the surroundings, "
            f"{self.stored:.3g} J stored; {self.residual:.1e} of it not accounted for"
        )


@dataclass(frozen=True)
class WorkBalance:
    """Where the mechanical work of a run went; over all elements, in J."""

    by_elements: float
    """What the shape-memory elements did on the mechanism."""
    outside: float
    """What the mechanism did on something else."""
    spent: float
    """What friction and damping took, less what motors gave."""
    springs: float
    """Held more than in the beginning."""
    gravity: float
    kinetic: float
    passed: float
    """All work that passed, without its sign."""

    @property
    def residual(self) -> float:
        """What is not accounted for, as a share of all that passed."""
        held = self.springs + self.gravity + self.kinetic
        missing = abs(self.by_elements - self.outside - self.spent - held)
        return missing / self.passed if self.passed > LEAST_HEAT else 0.0

    def __str__(self) -> str:
        """In a line; what is nothing is left out."""
        parts = {
            "to the outside": self.outside, "into friction, damping and motors": self.spent,
            "into springs": self.springs, "into weights": self.gravity, "into motion": self.kinetic,
        }  # fmt: skip
        parts = {"by the elements": self.by_elements} | parts
        least = 1e-6 * self.passed
        left = [f"{value:.3g} J {name}" for name, value in parts.items() if abs(value) > least]
        if not self.passed > LEAST_HEAT:
            return "work: none"
        return (
            f"work: {self.passed:.3g} J passed, {', '.join(left) or 'and came back'}; "
            f"{self.residual:.1e} of it not accounted for"
        )


LEAST_HEAT = 1e-9
"""Heat [J] below which nothing is balanced."""


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
    work: WorkBalance | None = None
    """Of a run with an error control, if the mechanism says what it holds."""
    heat: HeatBalance | None = None
    """Of a run with an error control; None where a law's heat of transformation is no constant, a
    temperature is prescribed, or steps are given."""
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
        balance = [] if self.heat is None else [str(self.heat)]
        return "\n".join([*lines, *balance, *self.warnings])

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
