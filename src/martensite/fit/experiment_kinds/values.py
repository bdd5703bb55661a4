"""Values, rows and columns for the proposals of all kinds of experiment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from martensite.signals.records import Record

SIGMA = 100e6
"""Assumed stress in an element of unknown section [Pa]."""
EPS = 0.04
"""Assumed transformation strain in an element of unknown length."""
ROOM = "22 degC"
SLOPE = 7.5e6
"""C_A and C_M if loops at one load do not determine them [Pa/K]."""
WAIST = ("waist_f=0.1..0.98", "waist_r=0.1..0.98")
LAGOUDAS = {"kind": "lagoudas", "sigma_crit": "0 MPa"} | dict.fromkeys(("n_1", "n_2", "n_3", "n_4"), 0.45)
MODULI = {"E_A": 70e9, "E_M": 28e9}
"""Assumed Young's moduli [Pa]."""
EXAMPLE_UNITS = {
    "time": "s",
    "temperature": "K",
    "strain": "1",
    "stress": "Pa",
    "force": "N",
    "position": "m",
    "resistance": "ohm",
    "voltage": "V",
    "current": "A",
    "duty": "1",
    "heat_flow": "W/kg",
}
Document = dict[str, Any]


def write_value(value: float, unit: str) -> str:
    """Return a value [SI] in scenario form, in a readable unit."""
    if unit == "K":
        return f"{value - 273.15:.8g} degC"
    if unit == "1":
        return f"{value:.8g}"
    large = {"m": ("mm", 1e-3), "m^2": ("mm^2", 1e-6), "Pa": ("MPa", 1e6), "Pa/K": ("MPa/K", 1e6)}
    words, factor = large.get(unit, (unit, 1.0))
    return f"{value / factor:.8g} {words}"


def write_values(unit: str, **values: float) -> Document:
    """Return values [SI] of one unit by name, in scenario form."""
    return {name: write_value(value, unit) for name, value in values.items()}


def with_column(record: Record, name: str, unit: str, values: Any) -> Record:
    """Return a record with a further column, by row or constant [SI unit]."""
    numbers = np.broadcast_to(np.asarray(values, float), len(record))
    return replace(record, columns=record.columns | {name: numbers}, units=record.units | {name: unit})


def make_record(columns: Mapping[str, Any], name: str = "log") -> Record:
    """Return a record [SI] of columns of equal length, with a row every second."""
    rows = len(next(iter(columns.values())))
    whole: dict[str, Any] = {"time": np.arange(float(rows)), **columns}
    return Record(name, whole, {one: EXAMPLE_UNITS[one] for one in whole})


def make_pulses() -> Any:
    """Return a drive from 0 to 1 that rises and falls three times, of 80 rows."""
    return np.sin(np.linspace(0.0, 9.0, 80)) ** 2


def make_loop() -> Any:
    """Return a ramp from 0 to 1 and back, of 80 rows."""
    return 1.0 - np.abs(np.linspace(-1.0, 1.0, 80))
