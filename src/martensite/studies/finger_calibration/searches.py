"""Coordinate search as in the paper, and least squares, from several starts.

The paper does not describe its variant of coordinate search; see `martensite.search.coordinate_search`. Least squares
uses a trust region within bounds, and exact derivatives.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from martensite.fit.fit import Fit
from martensite.fit.search_monitor import SearchNote
from martensite.fit.solve import solve_problem
from martensite.studies.finger_calibration import bench
from martensite.studies.finger_calibration.bench import EVERY, FAR, NEAR, Data
from martensite.studies.result_cache import cache_results
from martensite.studies.tables import Printed

STARTS = (
    (25e9, 345.0, 80e6, 10e6, 5.5e6),
    (20e9, 305.0, 60e6, 5e6, 4.5e6),
    (25e9, 330.0, 60e6, 5e6, 5e6),
    (33e9, 370.0, 120e6, 40e6, 6.5e6),
)
"""E_M [Pa], T_L [K], Δσ [Pa], σ_L [Pa], dσ/dT [Pa/K]; chosen for this study."""
STILL = 3
"""Start from which the finger does not move in the test."""
FEW, ALL = (0, STILL), (0, 1, 2, STILL)
"""Starts of coordinate search: by default, and in full."""
COORDINATE, SQUARES = "coordinate", "trf"


@dataclass(frozen=True)
class SearchPoint:
    """Point of a search."""

    runs: int
    """Runs so far, including those with derivatives."""
    rms: float
    """RMS error of the angle [°]."""
    numbers: dict[str, float]
    """Parameters [SI]."""


@dataclass(frozen=True)
class CalibrationSearch:
    """A search and its path."""

    fit: Fit
    path: tuple[SearchPoint, ...]
    """The start and each improvement."""

    @property
    def rms(self) -> float:
        """Return the RMS error of the angle at the end [°]."""
        return angle_rms(self.fit.cost)

    @property
    def runs(self) -> int:
        """Return the number of simulations, including those with derivatives."""
        return self.fit.simulations + self.fit.jacobians


def angle_rms(cost: float) -> float:
    """Return the root-mean-square error of the angle [°]."""
    return math.degrees(bench.NOISE * math.sqrt(cost))


@cache_results
def run_search(data: Data, start: int, method: str, printed: Printed, spread: int = 0) -> CalibrationSearch:
    """Return a search from one of the starts, and from `spread` additional ones."""
    records = bench.table_problem(data, printed).experiments
    problem = bench.build_calibration(records, printed, STARTS[start])
    notes: list[SearchNote] = []

    def tell(note: SearchNote) -> None:
        if not notes or note.cost < notes[-1].cost:
            notes.append(note)

    fit = solve_problem(problem, method=method, starts=spread, tell=tell)
    path = [
        SearchPoint(runs, angle_rms(cost), problem.numbers(note.values))
        for (runs, cost), note in zip(fit.history, notes, strict=True)
    ]
    return CalibrationSearch(fit, tuple(path))


def list_starts(full: bool) -> tuple[int, ...]:
    """Return the starts of coordinate search."""
    return ALL if full else FEW


def prepare_searches(printed: Printed, *, full: bool) -> None:
    """Run all searches, coordinate searches on two cores."""
    for data in EVERY:
        for start in moving_starts():
            run_search(data, start, SQUARES, printed)
    jobs = [(data, start) for data in (FAR, NEAR) for start in list_starts(full)]
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda job: run_search(job[0], job[1], COORDINATE, printed), jobs))


def moving_starts() -> tuple[int, ...]:
    """Return the starts from which the finger moves."""
    return tuple(start for start in ALL if start != STILL)


def best_fit(data: Data, printed: Printed) -> CalibrationSearch:
    """Return the best least-squares fit from a moving start."""
    fits = (run_search(data, start, SQUARES, printed) for start in moving_starts())
    return min(fits, key=lambda one: one.rms)


def end_spread(name: str, searches: Iterable[CalibrationSearch]) -> float:
    """Return the spread of a parameter at the ends of searches [SI]."""
    ends = [one.fit[name] for one in searches]
    return max(ends) - min(ends)
