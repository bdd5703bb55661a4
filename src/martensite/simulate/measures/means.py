"""Integrals over time, with the weights of the rows of a run."""

from __future__ import annotations

import numpy as np

from martensite.base.parameters import text
from martensite.simulate.measures.base import FIRST, MEASURES, AbstractMeasure
from martensite.simulate.measures.run_table import Numbers, RunTable


def sum_weighted(counts: Numbers, values: Numbers) -> Numbers:
    """Return the weighted sum of the values of every run, (runs,).

    Rows are added in sequence, so that sums are independent of the other runs.
    """
    shares = (counts[None] * values).reshape(-1, values.shape[2])
    return np.add.accumulate(shares, axis=0)[-1]


@MEASURES.register("integral")
class Integral(AbstractMeasure):
    """Integral over the run, of all elements together."""

    averages = True

    def unit(self, unit: str) -> str:
        """Return the unit of the output, times s."""
        return "s" if unit == "1" else f"{unit}*s"

    def weigh(self, table: RunTable) -> Numbers:
        """Return the weight of every row, (rows, runs)."""
        return table.weights

    def value(self, table: RunTable) -> Numbers:
        """Return ∫ y dt."""
        return sum_weighted(self.weigh(table), table.values)

    def derivatives(self, table: RunTable) -> Numbers:
        """Return the weights."""
        return np.broadcast_to(self.weigh(table)[None], table.values.shape).copy()


@MEASURES.register("energy")
class ElectricalEnergy(Integral):
    """Electrical energy into all elements."""

    of: str = text("power that is added up", default="power")

    def unit(self, unit: str) -> str:
        """Return joule for a power in watt."""
        return "J" if unit == "W" else super().unit(unit)


@MEASURES.register("mean")
class Mean(Integral):
    """Mean over the run; of several elements the sum of their means."""

    def unit(self, unit: str) -> str:
        """Return the unit of the output."""
        return unit

    def weigh(self, table: RunTable) -> Numbers:
        """Return the weights as fractions of the run."""
        return table.weights / table.durations


@MEASURES.register("rms")
class RootMeanSquare(AbstractMeasure):
    """Root of the mean square over the run; for several elements, of the sum of all squares."""

    averages = True

    of: str = text("output that is looked at; none for the first coordinate", default=FIRST)

    def unit(self, unit: str) -> str:
        """Return the unit of the output."""
        return unit

    def value(self, table: RunTable) -> Numbers:
        """Return √(∫ y² dt / T)."""
        return np.sqrt(sum_weighted(table.weights / table.durations, table.values**2))

    def derivatives(self, table: RunTable) -> Numbers:
        """Return y Δt / (T rms); 0 for a run that stays at 0."""
        size = self.value(table)
        safe = np.where(size > 0.0, size, 1.0)
        return (table.weights / table.durations)[None] * table.values / safe
