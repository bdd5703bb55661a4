"""`fit vibration`: reading the record of a free vibration, and what is printed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from martensite.base.errors import DataError, InputError, suggest_name
from martensite.cli.options import quantity

if TYPE_CHECKING:
    from martensite.characterise.estimate import MeasuredValue
    from martensite.characterise.free_vibration import LogDecrement
    from martensite.characterise.spectrum import SpectralPeak
    from martensite.signals.records import Record


@dataclass(frozen=True)
class Oscillator:
    """What vibrates: a stiffness or a moving mass, in SI; at most one of them is given."""

    stiffness: float | None
    mass: float | None

    @classmethod
    def read(cls, stiffness: str | None, mass: str | None) -> Oscillator:
        """Read the options.

        Raises:
            InputError: both are given, or one is not above 0.
            UnitError: one of them is no quantity, or of another dimension.
        """
        if stiffness is not None and mass is not None:
            raise InputError(
                "Give --stiffness or --mass, not both: the frequency tells the other one."
            )
        k = None if stiffness is None else quantity("stiffness", stiffness, "N/m")
        m = None if mass is None else quantity("mass", mass, "kg")
        for name, number in (("stiffness", k), ("mass", m)):
            if number is not None and not number > 0.0:
                raise InputError(f"Option `--{name}` must be above 0, but is {number:g}.")
        return cls(k, m)

    def derived(self, fit: LogDecrement) -> dict[str, tuple[MeasuredValue, str]]:
        """Mass or stiffness, and damping, by name with their units; empty if nothing is given."""
        from martensite.characterise.estimate import propagate_errors
        from martensite.characterise.free_vibration import damping_ratio, moving_mass

        def rate(period: float, delta: float) -> float:
            return math.hypot(2.0 * math.pi, delta) / period

        def damping(period: float, delta: float) -> float:
            omega = rate(period, delta)
            half = self.mass * omega if self.mass is not None else (self.stiffness or 0.0) / omega
            return 2.0 * damping_ratio(delta) * half

        c = propagate_errors(damping, fit.period, fit.decrement)
        if self.stiffness is not None:
            k = self.stiffness
            found = propagate_errors(lambda f: moving_mass(k, f), fit.frequency)
            return {"moving_mass": (found, "kg"), "damping": (c, "N*s/m")}
        if self.mass is not None:
            m = self.mass
            found = propagate_errors(lambda f: m * (2.0 * math.pi * f) ** 2, fit.frequency)
            return {"stiffness": (found, "N/m"), "damping": (c, "N*s/m")}
        return {}


def read_vibration(
    path: Path, column: str | None, start: str | None, end: str | None
) -> tuple[list[float], list[float], str]:
    """Times [s] and values of the part of a record between two times, and a name for the values.

    Raises:
        DataError: there is no such column, none to choose, no time, or no row in between.
        UnitError: `start` or `end` is no time.
    """
    from martensite.scenario.tables import read_table

    record = read_table(path)
    if record.interval is not None:
        raise DataError(f"`{path.name}` has no column `time`; a vibration needs one, `time [s]`.")
    name = _chosen(record, column)
    first = -math.inf if start is None else quantity("start", start, "s")
    last = math.inf if end is None else quantity("end", end, "s")
    rows = [k for k, time in enumerate(record.times) if first <= time <= last]
    if not rows:
        raise DataError(
            f"`{path.name}` has no rows between --start and --end: it goes from "
            f"{record.times[0]:.6g} s to {record.times[-1]:.6g} s."
        )
    unit = record.units[name]
    label = f"`{name}`" if unit == "1" else f"`{name}` [{unit}]"
    return [record.times[k] for k in rows], [record[name][k] for k in rows], label


def _chosen(record: Record, column: str | None) -> str:
    others = [name for name in record.columns if name != "time"]
    if column is None:
        if len(others) != 1:
            listed = ", ".join(f"`{name}`" for name in others) or "none"
            raise DataError(
                f"Give --column: record `{record.name}` has {len(others)} columns beside `time`, "
                f"{listed}."
            )
        return others[0]
    if column not in others:
        raise DataError(
            f"Record `{record.name}` has no column `{column}`. {suggest_name(column, others)}"
        )
    return column


# ---------------------------------------------------------------- printing


def as_dict(peak: SpectralPeak, fit: LogDecrement, oscillator: Oscillator) -> dict[str, Any]:
    """All numbers by name, for JSON."""
    derived = {name: number.to_dict() for name, (number, _) in oscillator.derived(fit).items()}
    return {"spectrum": peak.to_dict(), "decay": fit.to_dict(), "derived": derived}


def print_vibration(
    peak: SpectralPeak, fit: LogDecrement, oscillator: Oscillator, rows: int, label: str
) -> None:
    """Print frequency, decay and what follows for a given stiffness or mass."""
    from martensite.base.confidence import LEVEL
    from martensite.cli import show

    show.text(f"Free vibration of {label}, {rows} rows, {fit.cycles:g} cycles used", "bold")
    show.text(
        f"Spectrum: {peak.frequency:.5g} Hz, resolution {peak.resolution:.3g} Hz, "
        f"{peak.prominence:.3g} times the median of the spectrum"
    )
    found = [
        ("natural frequency", fit.frequency, "Hz"),
        ("damped frequency", fit.damped_frequency, "Hz"),
        ("logarithmic decrement", fit.decrement, ""),
        ("damping ratio", fit.zeta, ""),
        *((name.replace("_", " "), *one) for name, one in oscillator.derived(fit).items()),
    ]
    show.table(("quantity", "value", "unit"), [estimate_row(*one) for one in found], right="value")
    show.text(f"± half the {100 * LEVEL:g} % interval; rest at {fit.offset.value:.4g}.")


def estimate_row(name: str, estimate: MeasuredValue, unit: str) -> Sequence[str]:
    """A row of a table: name, value with half its interval, unit."""
    low, high = estimate.interval()
    half = 0.5 * (high - low)
    if half == 0.0:
        return name, f"{estimate.value:.6g}", unit
    if not math.isfinite(half):
        return name, f"{estimate.value:.6g} ± unknown", unit
    return name, f"{estimate.value:.6g} ± {half:.2g}", unit
