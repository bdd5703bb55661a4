"""One loop of a bench with the curves and limits for its tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from martensite.base.errors import InputError
from martensite.control.controllers.base import AbstractController
from martensite.control.loop.bench import Bench
from martensite.control.loop.findings import LoopFinding, find_source, list_limits
from martensite.control.loop.names import list_readings
from martensite.control.synthesis.rest_curves import RestCurve, compute_rest_curve, read_curve
from martensite.kernels.c99_lanes import BLOCK
from martensite.signals.sampling.sampled import Numbers

COARSE, SIGNALS = BLOCK, 2 * BLOCK
"""Signals on a branch: of a first pass, and of the final curve."""
EVEN = 0.2
"""Fraction of the signals that is spread evenly."""
BEYOND = 0.02
"""Fraction of the reachable range by which a reference may exceed it."""
SAMPLES = 4000
"""Largest number of samples of a reference."""


@dataclass(frozen=True, eq=False)
class LoopCase:
    """One loop of a bench."""

    bench: Bench
    drive: str
    controller: AbstractController
    duration: float
    """Duration of the run [s]."""
    others: Mapping[str, float] = field(default_factory=dict[str, float])

    @property
    def unit(self) -> str:
        """Return the SI unit of the controlled reading."""
        return list_readings(self.bench)[self.controller.measured].unit

    @cached_property
    def reference(self) -> Numbers:
        """Return the reference at samples of the run."""
        count = min(int(self.duration / self.bench.period) + 1, SAMPLES)
        return np.array([float(self.controller.reference.value(t)) for t in np.linspace(0.0, self.duration, count)])

    @cached_property
    def limits(self) -> tuple[float, float]:
        """Return the least and largest signal that the controller and the source can give."""
        source, ohms = find_source(self.bench.plant, self.drive)
        levels = list_limits(self.controller).values()
        reach = (-np.inf, np.inf) if source is None else source.reach(ohms)
        low, high = (min(levels), max(levels)) if levels else reach
        low, high = max(low, reach[0], 0.0), min(high, reach[1])
        if not (np.isfinite(high) and low < high):
            raise InputError("no limits of the signal are known")
        return low, high

    @cached_property
    def heating(self) -> RestCurve:
        """Return the steady states under rising signals."""
        return self.compute_branch(self.limits[1], None)

    @cached_property
    def cooling(self) -> RestCurve:
        """Return the steady states under falling signals from the end of the heating branch."""
        return self.compute_branch(self.limits[1], self.heating.states[:, -1])

    def compute_branch(self, high: float, start: Numbers | None) -> RestCurve:
        """Return the steady states for signals up to `high`, dense where the reading changes; cooling from `start`."""

        def settle(row: Numbers) -> RestCurve:
            return compute_rest_curve(self.bench.plant, self.drive, row, others=self.others, start=start)

        coarse = settle(np.linspace(self.limits[0], high, COARSE))
        moved = np.abs(np.diff(self.read(coarse)))
        path = np.cumsum([0.0, *(moved + EVEN * max(moved.sum(), 1e-300) / COARSE)])
        return settle(np.interp(np.linspace(0.0, path[-1], SIGNALS), path, coarse.levels))

    def list_reached(self) -> Numbers:
        """Return the readings on the heating branches of this drive, led drives, and drives with the same reading."""
        own = self.controller
        members = {**self.bench.controllers.members(), **dict.fromkeys(own.led_drives(), own), self.drive: own}
        peers = [(name, one) for name, one in members.items() if one.measured == own.measured and name != self.drive]
        every = [self, *(LoopCase(self.bench, *peer, self.duration, self.others) for peer in peers)]
        return np.concatenate([one.read(one.heating) for one in every])

    def read(self, curve: RestCurve) -> Numbers:
        """Return the controlled reading along a branch."""
        return read_curve(self.bench, curve, self.controller.measured)

    def find(
        self, test: str, place: str, texts: tuple[str, str], number: tuple[float, float, str], fault: bool = False
    ) -> LoopFinding:
        """Return a finding about this loop from (sentence, remedy) and (value, limit, unit)."""
        where = place if "." in place else f"{place}.{self.drive}"
        return LoopFinding(test, where, texts[0], float(number[0]), float(number[1]), number[2], texts[1], fault)
