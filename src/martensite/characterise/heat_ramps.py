"""Ramps of a calorimeter: apparent heat capacity over temperature.

Within a ramp of rate dT/dt the heat flow q into the sample (endothermic) is

    q = c dT/dt + z,    c_app(T) = q/(dT/dt) = c(T) + z/(dT/dt)

with the zero z of the instrument. A transformation on heating absorbs heat and one on cooling releases heat, so it is
a positive peak of c_app in both directions. This fixes the sign of files, which count heat flow either way.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from martensite.base import units
from martensite.base.errors import DataError, ParameterError, UnitError
from martensite.characterise.loop_paths import FULL, find_turns
from martensite.logs.heading_guess import HEAT
from martensite.signals.records import Record

SPECIFIC, POWER, PLAIN = "W/kg", "W", "1"
ASSUMED = "W/g"
"""Unit of a heat flow without unit in its file."""
LEAST_RANGE = 20.0
"""Least range of a ramp [K]."""
STEADY = 0.3
"""Largest relative deviation of the local from the median rate within a ramp."""
CELLS = 1000
"""Largest number of rows of a ramp; more are averaged in cells of equal temperature width."""
FEWEST = 30
"""Least number of rows of a ramp."""


@dataclass(frozen=True)
class HeatRamp:
    """One heating or cooling of a calorimeter at constant rate."""

    name: str
    """Name of its record."""
    number: int
    """Number in the record, from 1."""
    temperature: Any
    """Rising temperatures (rows,) [K]."""
    capacity: Any
    """Apparent heat capacity (rows,) [J/kg/K], with the sign of the file."""
    rate: float
    """[K/s], negative for cooling."""

    @property
    def is_heating(self) -> bool:
        """Return whether the ramp rises."""
        return self.rate > 0.0

    @property
    def label(self) -> str:
        """Return the direction and the rate: `heating, 10 K/min`."""
        return f"{'heating' if self.is_heating else 'cooling'}, {60.0 * abs(self.rate):.3g} K/min"


def has_heat_flow(record: Record) -> bool:
    """Return whether a record has a heat flow and a temperature that varies."""
    names = [name for name in record.columns if HEAT.search(name)]
    kelvin = np.asarray(record.columns.get("temperature", [0.0]), float)
    return bool(names) and float(np.nanmax(kelvin) - np.nanmin(kelvin)) > LEAST_RANGE


def cut_ramps(record: Record, mass: float | None = None, rate: float | None = None) -> list[HeatRamp]:
    """Return the ramps of a calorimeter record.

    Args:
        record: columns `temperature` [K] and `heat_flow` [W/kg or W], with times.
        mass: mass of the sample [kg], required for a heat flow in watts.
        rate: heating rate [K/s] of a record without times.

    Raises:
        DataError: a column, the mass or the times are missing, or there is no ramp.
    """
    heat = _find_heat_flow(record, mass)
    kelvin, times = np.asarray(record["temperature"], float), np.asarray(record.times, float)
    rows = np.flatnonzero(np.isfinite(kelvin) & np.isfinite(heat))
    if rows.size < FEWEST:
        raise DataError(
            f"Record `{record.name}` has {rows.size} rows of temperature and heat flow; needed are {FEWEST}."
        )
    kelvin, times, heat = kelvin[rows], times[rows], heat[rows]
    span = float(np.ptp(kelvin))
    if span < LEAST_RANGE:
        raise DataError(
            f"The temperature of record `{record.name}` spans {span:.3g} K; a ramp needs {LEAST_RANGE:g} K."
        )
    if record.interval is not None:
        if rate is None:
            raise DataError(f'Record `{record.name}` has no times: give the heating rate (`--rate "10 K/min"`).')
        times = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(kelvin)))]) / rate
    turns = find_turns(kelvin.tolist(), FULL * span) or [0, len(kelvin) - 1]
    pairs = [(a, b) for a, b in pairwise(turns) if abs(kelvin[b] - kelvin[a]) >= FULL * span]
    ramps = [
        one
        for number, (a, b) in enumerate(pairs, start=1)
        if (one := _cut_ramp((record.name, number), kelvin[a : b + 1], times[a : b + 1], heat[a : b + 1])) is not None
    ]
    if not ramps:
        raise DataError(
            f"Record `{record.name}` holds no ramp of constant rate; does the temperature belong to the sample?"
        )
    return ramps


def find_heat_unit(record: Record) -> str:
    """Return the unit of the heat flow of a record: `W/kg`, `W`, or `1` if the file has none."""
    return record.units[_find_name(record)]


def read_mass(header_entries: Mapping[str, str]) -> float | None:
    """Return the sample mass [kg] in the lines above a table; None without one."""
    for key, text in header_entries.items():
        if re.search(r"\bsize\b|mass|weight|einwaage", key):
            unit = next((u for u in ("mg", "g") if re.search(rf"\b{u}\b", f"{text} {key}")), "")
            number = re.search(r"\d+(?:[.,]\d+)?", text)
            if unit and number:
                return units.parse_quantity(f"{number[0].replace(',', '.')} {unit}", "kg")
    return None


def _find_name(record: Record) -> str:
    names = [name for name in record.columns if HEAT.search(name)]
    if not names:
        raise DataError(
            f"Record `{record.name}` has no heat flow: name its column, for example `--as 3=heat_flow[W/g]`."
        )
    return "heat_flow" if "heat_flow" in names else names[0]


def _find_heat_flow(record: Record, mass: float | None) -> Any:
    """Return the heat flow of a record, (rows,) [W/kg]."""
    name = _find_name(record)
    unit, numbers = record.units[name], np.asarray(record[name], float)
    if mass is not None and not 0.0 < mass < math.inf:
        raise ParameterError(f"Argument `mass` must be above 0 kg, but is {mass} kg.")
    if unit == POWER:
        if mass is None:
            raise DataError(
                f'`{name}` of record `{record.name}` is in W: give the mass of the sample (`--mass "12 mg"`).'
            )
        return numbers / mass
    try:
        return numbers * units.find_conversion(ASSUMED if unit == PLAIN else unit, SPECIFIC)[0]
    except UnitError:
        raise DataError(f"`{name}` of record `{record.name}` is in {unit}, but must be in W/g or W.") from None


def _cut_ramp(where: tuple[str, int], kelvin: Any, times: Any, heat: Any) -> HeatRamp | None:
    """Return the part of a leg with a steady rate; None for a leg that is too short."""
    mean = float((kelvin[-1] - kelvin[0]) / max(times[-1] - times[0], 1e-12))
    wide = max(len(kelvin) // 50, 1)
    clock = np.maximum.accumulate(times + 1e-9 * np.arange(len(times)))
    window = np.ones(2 * wide + 1) / (2 * wide + 1)
    local = np.convolve(np.gradient(kelvin, clock), window, "same")
    rate = float(np.median(local[np.abs(local) > 0.5 * abs(mean)])) if mean else 0.0
    good = np.abs(local / rate - 1.0) < STEADY if rate else np.zeros(0, bool)
    good[: wide + 1] = good[wide + 1] if len(good) > wide + 1 else False
    good[len(good) - wide - 1 :] = good[-wide - 2] if len(good) > wide + 2 else False
    if good.sum() < FEWEST or np.ptp(kelvin[good]) < LEAST_RANGE:
        return None
    order = np.argsort(kelvin[good], kind="stable")
    x, y = kelvin[good][order], (heat[good] / rate)[order]
    x, y = _average(x, y, min(CELLS, len(x)))
    return HeatRamp(where[0], where[1], x, y, rate)


def _average(x: Any, y: Any, cells: int) -> tuple[Any, Any]:
    """Return rows at the middles of cells of equal width, empty cells by straight lines."""
    edges = np.linspace(x[0], x[-1], cells + 1)
    place = np.clip(np.searchsorted(edges, x, "right") - 1, 0, cells - 1)
    count = np.bincount(place, minlength=cells)
    filled = count > 0
    at, level = (np.bincount(place, column, cells)[filled] / count[filled] for column in (x, y))
    middles = 0.5 * (edges[1:] + edges[:-1])
    return middles, np.interp(middles, at, level)


def list_rates(ramps: list[HeatRamp]) -> Iterator[float]:
    """Yield the distinct rates of some ramps [K/s], by magnitude."""
    last = 0.0
    for rate in sorted(abs(one.rate) for one in ramps):
        if rate > 1.2 * last:
            yield rate
            last = rate
