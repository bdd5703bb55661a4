"""The result of a simulation: sampled columns in SI units, with status and accuracy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from martensite.signals.base import AbstractWaveform
from martensite.simulate.alarms import Alarm
from martensite.status import Status
from martensite.system import OUTPUTS, PROFILES, System


@dataclass(frozen=True)
class Result:
    """Columns over time, and how far they can be trusted."""

    system: System
    waveform: AbstractWaveform
    times: list[float]
    """Sample times [s]."""
    columns: dict[str, list[float]]
    """One list per output named in `martensite.system.OUTPUTS`, in SI units."""
    status: Status
    """The worst status of all steps; a failed run has no result but raises."""
    status_time: float | None
    """Start of the first step with the worst status [s], where recorded."""
    steps: int
    step: float
    """Longest step taken [s]."""
    accuracy: float | None = None
    """Largest difference to the run with twice the step, as a share of each column's range
    (temperature, martensite fraction, position); None if only one run was made."""
    warnings: list[str] = field(default_factory=list[str])
    """Sentences on exceeded limits, slack, a saturated supply, coarse steps."""
    alarms: list[Alarm] = field(default_factory=list[Alarm])
    """Exceeded limits, slack and a saturated supply, with time, duration and amount."""

    profiles: dict[str, list[list[float]]] = field(default_factory=dict[str, list[list[float]]])
    """One list per cell and quantity named in `martensite.system.PROFILES`, in SI units; empty
    for an element that is the same all over."""

    def __getitem__(self, name: str) -> list[float]:
        """A column by name, or the times."""
        return self.times if name == "time" else self.columns[name]

    def unit(self, name: str) -> str:
        """SI unit of a column."""
        if name == "time":
            return "s"
        return self.system.source.unit if name == "drive" else OUTPUTS[name][0]

    def range(self, name: str) -> float:
        """Largest minus smallest value of a column, in SI."""
        return max(self[name]) - min(self[name])

    @property
    def stroke(self) -> float:
        """Largest position less smallest [m]."""
        return self.range("position")

    def __str__(self) -> str:
        """A summary of a few lines."""
        hot, cold = max(self["temperature"]) - 273.15, min(self["temperature"]) - 273.15
        accuracy = "not estimated" if self.accuracy is None else f"{self.accuracy:.1e} of range"
        lines = [
            f"{self.times[-1]:.6g} s in {self.steps} steps of at most {self.step:.3g} s, "
            f"accuracy {accuracy}",
            f"temperature {cold:.1f} to {hot:.1f} °C",
            f"stroke {self.stroke * 1e3:.3f} mm",
            f"martensite fraction {min(self['martensite_fraction']):.3f} to "
            f"{max(self['martensite_fraction']):.3f}",
            f"stress {min(self['stress']) / 1e6:.1f} to {max(self['stress']) / 1e6:.1f} MPa",
        ]
        return "\n".join([*lines, *self.warnings])


def profiles_of(rows: Sequence[Sequence[float]]) -> dict[str, list[list[float]]]:
    """The profiles among rows of all outputs."""
    first = len(OUTPUTS)
    cells = (len(rows[0]) - first) // len(PROFILES)
    starts = {name: first + k * cells for k, name in enumerate(PROFILES)}
    return {
        name: [[row[start + i] for row in rows] for i in range(cells)]
        for name, start in starts.items()
        if cells
    }
