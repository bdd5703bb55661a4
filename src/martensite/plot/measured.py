"""Measured records beside a simulation: dots or a grey line, and the RMS difference.

The difference is taken at the measured samples inside the simulated time, where the result
is interpolated linearly; gaps (NaN) in a record are left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from martensite.errors import DataError
from martensite.plot.labels import Axis, axis
from martensite.plot.style import MEASURED
from martensite.simulate.result import Result
from martensite.system import OUTPUTS

DOTS = 150
"""Records of more samples than this are drawn as lines."""
NAMED = 2
"""More records than this share one entry in the legend."""


class Record(Protocol):
    """What a figure needs of a record: columns in SI under the names of `OUTPUTS`."""

    @property
    def name(self) -> str:
        """Name of the record."""
        ...

    @property
    def columns(self) -> Mapping[str, Sequence[float]]:
        """Columns in SI units, `time` [s] among them."""
        ...

    @property
    def units(self) -> Mapping[str, str]:
        """SI unit of each column."""
        ...


@dataclass(frozen=True)
class Overlay:
    """One measured column over time, in the unit of its axis."""

    name: str
    times: Any
    values: Any
    misfit: Any
    """Measured less simulated at the samples inside the simulated time."""


def check_records(result: Result, records: Iterable[Record] | None) -> list[Record]:
    """The records as a list, each known to hold times and something to compare.

    Raises:
        DataError: a record has no times, or no column of the result in its unit, or lies
            outside the simulated time.
    """
    found = list(records or ())
    for record in found:
        if "time" not in record.columns:
            raise DataError(f"The record `{record.name}` has no column `time`.")
        if not recorded(result, [record]):
            listed = ", ".join(f"`{name}` [{result.unit(name)}]" for name in OUTPUTS)
            raise DataError(
                f"The record `{record.name}` has no column to compare; possible are {listed}."
            )
        if not _inside(result, np.asarray(record.columns["time"], np.float64)).any():
            raise DataError(
                f"The record `{record.name}` has no sample between 0 and "
                f"{result.times[-1]:.6g} s, the time simulated."
            )
    return found


def recorded(result: Result, records: Iterable[Record]) -> list[str]:
    """Names of the outputs that at least one of the records holds."""
    records = list(records)
    return [name for name in OUTPUTS if any(_holds(result, r, name) for r in records)]


def overlays(result: Result, records: Iterable[Record], name: str) -> list[Overlay]:
    """The measured columns `name` of all records that have it, ready to draw."""
    shown = axis(result, name)
    return [_overlay(result, r, shown) for r in records if _holds(result, r, name)]


def pairs(
    result: Result, records: Iterable[Record], x: str, y: str
) -> list[tuple[str, Any, Any]]:
    """Name, x and y in shown units of all records that have both columns."""
    horizontal, vertical = axis(result, x), axis(result, y)
    return [
        (r.name, horizontal.values(r.columns[x]), vertical.values(r.columns[y]))
        for r in records
        if _holds(result, r, x) and _holds(result, r, y)
    ]


def rms(misfits: Iterable[Any]) -> float:
    """Root mean square over all samples together; NaN if there are none."""
    joined = np.concatenate([np.zeros(0), *misfits])
    return float(np.sqrt(np.mean(joined**2))) if joined.size else float("nan")


def draw_overlays(axes: Any, shown: Axis, found: Sequence[Overlay]) -> None:
    """Draw measured columns over time, with the RMS difference in their legend entries."""
    together = len(found) > NAMED
    for i, overlay in enumerate(found):
        label = _legend(shown, overlay.name, [overlay]) if not together else "_nolegend_"
        if together and i == 0:
            label = _legend(shown, f"{len(found)} records", found)
        axes.plot(
            overlay.times, overlay.values, label=label, **look(len(overlay.times), i)
        )


def look(samples: int, i: int) -> dict[str, Any]:
    """Line properties of the i-th record: dots if it is short, else a thin line."""
    colour = MEASURED[i % len(MEASURED)]
    if samples > DOTS:
        return {"color": colour, "linewidth": 0.9, "alpha": 0.9, "zorder": 1.8}
    return {
        "color": colour, "linestyle": "none", "marker": "o", "markersize": 2.8,
        "markeredgewidth": 0.0, "zorder": 2.5,
    }  # fmt: skip


def _legend(shown: Axis, name: str, found: Sequence[Overlay]) -> str:
    value = f"{rms(o.misfit for o in found):.3g} {shown.difference_unit}".rstrip()
    name = name if len(name) <= 24 else name[:23] + "…"
    return f"{name}: RMS {value}"


def _holds(result: Result, record: Record, name: str) -> bool:
    return name in record.columns and record.units.get(name) == result.unit(name)


def _overlay(result: Result, record: Record, shown: Axis) -> Overlay:
    times = np.asarray(record.columns["time"], np.float64)
    values = shown.values(record.columns[shown.name])
    use = _inside(result, times) & np.isfinite(values)
    simulated = np.interp(times[use], result.times, shown.values(result[shown.name]))
    return Overlay(record.name, times, values, values[use] - simulated)


def _inside(result: Result, times: Any) -> Any:
    return (times >= result.times[0]) & (times <= result.times[-1])
