"""The record, reduced to plateaus: R = (V - V₀)/I with the authors' offset V₀.

By the time stamps of logger and camera, the wire warms within ten seconds of the current. The camera temperature is
apparent, since the wire is thinner than a pixel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, cached_property
from statistics import fmean

from martensite.characterise.regression import fit_powers
from martensite.design.sizing.cycle import find_crossing
from martensite.logs import datasets
from martensite.logs.reader import read_table
from martensite.signals.records import Record
from martensite.studies.electrothermal.staircase import SupplyOffset, reduce_to_plateaus, supply_offset, unwrap_counter
from martensite.studies.tables import Printed

DATA = "flexinol-electrothermal"
UNTRAINED = f"{DATA}/untrained_wire_voltage_current_run5.txt"
WARMTH = f"{DATA}/untrained_wire_temperature_run5.txt"
TRAINED = f"{DATA}/trained_wire_172MPa_electric.txt"
LATER = 5207.558
"""Start of the logger after the camera [s]: stamps 18:54:21 and 17:27:33.442."""
_SLACK = 1e-6


@dataclass(frozen=True)
class RecordStaircase:
    """Plateaus of run 5, with derived quantities."""

    stated: Printed

    @cached_property
    def table(self) -> Record:
        """Return the plateaus with set-point [V], current [A] and apparent temperature [K]."""
        return reduce_to_plateaus(_join_rows(), "set_point")

    @cached_property
    def resistance(self) -> list[float]:
        """Return the resistance on each plateau [ohm]."""
        return self.resistances(self.stated.offset)

    def resistances(self, offset: float) -> list[float]:
        """Return the resistance on each plateau [ohm] with an offset of the set-point [V]."""
        pairs = zip(self.table["set_point"].tolist(), self.table["current"].tolist(), strict=True)
        return [(volt - offset) / current for volt, current in pairs]

    def within(self, low: float, high: float) -> list[int]:
        """Return the indices of the plateaus between two set-points [V]."""
        volts = self.table["set_point"]
        return [i for i, volt in enumerate(volts) if low - _SLACK <= volt <= high + _SLACK]

    def mean(self, low: float, high: float) -> float:
        """Return the mean resistance between two set-points [ohm]."""
        return fmean(self.resistance[i] for i in self.within(low, high))

    def extremes(self, low: float, high: float) -> tuple[float, float]:
        """Return the lowest and highest resistance between two set-points [ohm]."""
        resistances = [self.resistance[i] for i in self.within(low, high)]
        return min(resistances), max(resistances)

    def drop(self) -> tuple[float, float]:
        """Return the currents of the last plateau before the drop, and the first settled one after it [A].

        Settled is a resistance within 1 % of its mean as austenite.
        """
        current, limit = self.table["current"], 1.01 * self.mean(*self.stated.hot)
        last = self.within(*self.stated.cold)[-1]
        hot = self.within(self.stated.cold[1], self.stated.hot[1])
        settled = 1 + max(i for i in hot if self.resistance[i] > limit)
        return current[last].item(), current[settled].item()

    def half_way(self) -> float:
        """Return the current at half of the drop, linear between plateaus [A]."""
        level = 0.5 * (self.mean(*self.stated.cold) + self.mean(*self.stated.hot))
        current, resistance = self.table["current"], self.resistance
        last = self.within(*self.stated.cold)[-1]
        below = find_crossing(current[last:], [-ohms for ohms in resistance[last:]], -level)
        return math.nan if below is None else below

    def rise(self) -> float:
        """Return the relative rise of the resistance of austenite per 40 K of apparent temperature."""
        places = self.within(self.stated.hot[0], 4.5)
        warmth = [self.table["apparent_temperature"][i] for i in places]
        line = fit_powers(warmth, [self.resistance[i] for i in places], (0, 1))
        return 40.0 * line.values[1] / self.mean(*self.stated.hot)

    def offset(self, low: float, high: float) -> SupplyOffset:
        """Return the supply offset of the plateaus between two set-points [V]."""
        return supply_offset(self.table, "set_point", "current", low, high)

    def jumps(self) -> int:
        """Return the number of falls of the set-point by the stated drop."""
        return len(unwrap_counter(_join_rows()["set_point"].tolist(), self.stated.drop).jumps)


def has_files(*files: str) -> bool:
    """Return whether files of the data set are on this machine."""
    return all(datasets.is_here(file) for file in files)


def trained_slopes(low: tuple[float, float], high: tuple[float, float]) -> list[SupplyOffset]:
    """Return the lines through the trained run in two ranges of set-points [V]."""
    table = reduce_to_plateaus(read_table(f"data:{TRAINED}"), "set_point", settled=0.3)
    return [supply_offset(table, "set_point", "current", *span) for span in (low, high)]


@cache
def _join_rows() -> Record:
    """Return the rows of the logger, with the simultaneous apparent temperature."""
    import numpy as np

    rows, camera = read_table(f"data:{UNTRAINED}"), read_table(f"data:{WARMTH}")
    times = rows.times + LATER
    apparent = np.interp(times, camera.times, camera["apparent_temperature"])
    columns = rows.columns | {"apparent_temperature": apparent}
    units = rows.units | {"apparent_temperature": "K"}
    return Record(rows.name, columns, units, rows.source, rows.dropped)
