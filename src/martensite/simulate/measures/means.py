"""Integrals over time, by trapezoids on the samples."""

from __future__ import annotations

import numpy as np

from martensite.base.parameters import text
from martensite.simulate.measures.base import FIRST, MEASURES, AbstractMeasure, Numbers


def weigh_trapezoids(times: Numbers) -> Numbers:
    """What every sample counts in an integral [s], (samples,)."""
    steps = np.diff(times)
    return 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))


def sum_weighted(counts: Numbers, seen: Numbers) -> Numbers:
    """Samples times what each counts, of all columns, (runs,).

    Added one after another: other ways depend on how many runs are beside one.
    """
    shares = (counts[None, :, None] * seen).reshape(-1, seen.shape[2])
    return np.add.accumulate(shares, axis=0)[-1]


@MEASURES.register("integral")
class Integral(AbstractMeasure):
    """Integral over the run, of all elements together."""

    def unit(self, unit: str) -> str:
        """That of the output, times s."""
        return "s" if unit == "1" else f"{unit}*s"

    def counts(self, times: Numbers) -> Numbers:
        """What every sample counts, (samples,)."""
        return weigh_trapezoids(times)

    def value(self, times: Numbers, seen: Numbers) -> Numbers:
        """∫ y dt."""
        return sum_weighted(self.counts(times), seen)

    def weights(self, times: Numbers, seen: Numbers) -> Numbers:
        """The trapezoids."""
        return np.broadcast_to(self.counts(times)[None, :, None], seen.shape).copy()


@MEASURES.register("energy")
class ElectricalEnergy(Integral):
    """Electrical energy into all elements."""

    of: str = text("power that is added up", default="power")

    def unit(self, unit: str) -> str:
        """Joule for a power in watt."""
        return "J" if unit == "W" else super().unit(unit)


@MEASURES.register("mean")
class Mean(Integral):
    """Mean over the run; of several elements the sum of their means."""

    def unit(self, unit: str) -> str:
        """That of the output."""
        return unit

    def counts(self, times: Numbers) -> Numbers:
        """Trapezoids as shares of the run."""
        return weigh_trapezoids(times) / (times[-1] - times[0])


@MEASURES.register("rms")
class RootMeanSquare(AbstractMeasure):
    """Root of the mean square over the run; of several elements that of all squares."""

    of: str = text("output that is looked at; none for the first coordinate", default=FIRST)

    def unit(self, unit: str) -> str:
        """That of the output."""
        return unit

    def value(self, times: Numbers, seen: Numbers) -> Numbers:
        """√(∫ y² dt / T)."""
        counts = weigh_trapezoids(times) / (times[-1] - times[0])
        return np.sqrt(sum_weighted(counts, seen**2))

    def weights(self, times: Numbers, seen: Numbers) -> Numbers:
        """y Δt / (T rms); 0 for a run that stays at 0."""
        counts = weigh_trapezoids(times) / (times[-1] - times[0])
        size = self.value(times, seen)
        safe = np.where(size > 0.0, size, 1.0)
        return counts[None, :, None] * seen / safe
