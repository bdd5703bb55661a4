"""Measured records over a simulation: dots or a grey line, and the RMS difference.

The difference is taken at measured samples within the simulated time, with linear interpolation of the result; gaps
(NaN) in a record are ignored.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from martensite.base.errors import DataError
from martensite.control.controllers.base import AbstractController
from martensite.show.figures.labels import QuantityAxis, describe_axis
from martensite.show.figures.panels import add_key, shorten_name
from martensite.show.figures.style import MEASURED, SIMULATED
from martensite.simulate.result import Result

DOTS = 150
"""Largest number of samples drawn as dots."""
NAMED = 2
"""Largest number of records with separate RMS values; for more, the RMS covers all together."""
KEYED = 5
"""Largest number of key entries."""


class MeasuredRecord(Protocol):
    """Record for a figure: columns in SI under the names of outputs."""

    @property
    def name(self) -> str:
        """Return the name of the record."""
        ...

    @property
    def columns(self) -> Mapping[str, Sequence[float]]:
        """Return the columns in SI units, including `time` [s]."""
        ...

    @property
    def units(self) -> Mapping[str, str]:
        """Return the SI unit of each column."""
        ...


Records = Iterable[MeasuredRecord] | None
Outside = Mapping[str, AbstractController] | None
"""Controllers outside of a bench, by drive."""


@dataclass(frozen=True)
class Overlay:
    """One measured column over time, in the unit of its axis."""

    times: Any
    values: Any
    misfit: Any
    """Measured minus simulated at samples within the simulated time."""
    line: dict[str, Any]
    """Line properties of its record."""


def check_records(result: Result, records: Records) -> list[MeasuredRecord]:
    """Return the records as a list, after a check."""
    checked = list(records or ())
    for record in checked:
        if "time" not in record.columns:
            raise DataError(f"The record `{record.name}` has no column `time`.")
        if not list_recorded(result, [record]):
            listed = ", ".join(f"`{name}` [{result.unit(name)}]" for name in result.outputs)
            raise DataError(f"The record `{record.name}` has no column to compare; possible are {listed}.")
        if not _mask_inside(result, np.asarray(record.columns["time"], np.float64)).any():
            raise DataError(
                f"The record `{record.name}` has no sample between 0 and {result.times[-1]:.6g} s, the time simulated."
            )
    return checked


def list_recorded(result: Result, records: Iterable[MeasuredRecord]) -> list[str]:
    """Return the names of the outputs that at least one of the records holds."""
    records = list(records)
    return [name for name in result.outputs if any(_has_column(result, r, name) for r in records)]


def find_overlays(result: Result, records: Iterable[MeasuredRecord], name: str) -> list[Overlay]:
    """Return the measured columns `name` of all records that have it."""
    axis = describe_axis(result, name)
    return [
        _make_overlay(result, r, axis, choose_look(r, i)) for i, r in enumerate(records) if _has_column(result, r, name)
    ]


def pair_columns(
    result: Result, records: Iterable[MeasuredRecord], x: str, y: str
) -> list[tuple[Any, Any, dict[str, Any]]]:
    """Return x, y (in displayed units) and line properties of all records with both columns."""
    horizontal, vertical = describe_axis(result, x), describe_axis(result, y)
    return [
        (horizontal.values(r.columns[x]), vertical.values(r.columns[y]), choose_look(r, i))
        for i, r in enumerate(records)
        if _has_column(result, r, x) and _has_column(result, r, y)
    ]


def draw_overlays(axes: Any, axis: QuantityAxis, overlays: Sequence[Overlay]) -> None:
    """Draw measured columns over time, with the RMS difference in the legend."""
    for i, overlay in enumerate(overlays):
        if len(overlays) <= NAMED:
            label = _describe_rms(axis, [overlay])
        else:
            label = _describe_rms(axis, overlays) if i == 0 else "_nolegend_"
        axes.plot(overlay.times, overlay.values, label=label, **overlay.line)


def draw_key(figure: Any, records: Sequence[MeasuredRecord], below: float) -> None:
    """Draw the key of simulation and records."""
    from matplotlib.lines import Line2D

    looks: list[dict[str, Any]] = [{"color": SIMULATED}, *(choose_look(r, i) for i, r in enumerate(records))]
    lines = [Line2D([], [], **line) for line in looks]
    names = ["simulated", *(shorten_name(r.name, 36) for r in records)]
    add_key(figure, lines[:KEYED], names[:KEYED], below=below)


def choose_look(record: MeasuredRecord, i: int) -> dict[str, Any]:
    """Return the line properties of the i-th record: dots if it is short, else a thin line."""
    colour = MEASURED[i % len(MEASURED)]
    if len(record.columns["time"]) > DOTS:
        return {"color": colour, "linewidth": 0.9, "alpha": 0.9, "zorder": 1.8}
    return {
        "color": colour,
        "linestyle": "none",
        "marker": "o",
        "markersize": 2.8,
        "markeredgewidth": 0.0,
        "zorder": 2.5,
    }


def _describe_rms(axis: QuantityAxis, overlays: Sequence[Overlay]) -> str:
    misfit = np.concatenate([overlay.misfit for overlay in overlays])
    if not misfit.size:
        return "no sample to compare"
    value = f"{np.sqrt(np.mean(misfit**2)):.3g} {axis.difference_unit}".rstrip()
    return f"RMS {value}" if len(overlays) == 1 else f"RMS {value} ({len(overlays)} records)"


def _has_column(result: Result, record: MeasuredRecord, name: str) -> bool:
    return name in record.columns and record.units.get(name) == result.unit(name)


def _make_overlay(result: Result, record: MeasuredRecord, axis: QuantityAxis, line: dict[str, Any]) -> Overlay:
    times = np.asarray(record.columns["time"], np.float64)
    values = axis.values(record.columns[axis.name])
    use = _mask_inside(result, times) & np.isfinite(values)
    simulated = np.interp(times[use], result.times, axis.values(result[axis.name]))
    return Overlay(times, values, values[use] - simulated, line)


def _mask_inside(result: Result, times: Any) -> Any:
    return (times >= result.times[0]) & (times <= result.times[-1])
