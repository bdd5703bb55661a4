"""Both searches, from several starts: coordinate search as in the paper, and least squares.

Coordinate search here: one parameter at a time, a tenth of its range up or down, twice that
after a round with an improvement and half of it after one without, until it is below a
thousandth (`martensite.search.coordinate_search`). That of the paper's software is not described
in the paper. Least squares: trust region within bounds, exact derivatives.
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
"""The start from which the finger does not move at all in the test."""
FEW, ALL = (0, STILL), (0, 1, 2, STILL)
"""Starts of coordinate search: by default, and in full."""
COORDINATE, SQUARES = "coordinate", "trf"


@dataclass(frozen=True)
class SearchPoint:
    """Point of a search."""

    runs: int
    """Runs so far, those with derivatives included."""
    rms: float
    """RMS error of the angle [°]."""
    numbers: dict[str, float]
    """[SI]"""


@dataclass(frozen=True)
class CalibrationSearch:
    """A search and its way."""

    fit: Fit
    path: tuple[SearchPoint, ...]
    """The start and every improvement."""

    @property
    def rms(self) -> float:
        """Return the RMS error of the angle at the end [°]."""
        return angle_rms(self.fit.cost)

    @property
    def runs(self) -> int:
        """Simulations, those with derivatives included."""
        return self.fit.simulations + self.fit.jacobians


def angle_rms(cost: float) -> float:
    """Return the root-mean-square error of the angle [°]."""
    return math.degrees(bench.NOISE * math.sqrt(cost))


@cache_results
def run_search(data: Data, start: int, method: str, printed: Printed, spread: int = 0) -> CalibrationSearch:
    """Return a search from one of the starts, and from as many more as `spread` says."""
    records = bench.table_problem(data, printed).experiments
    problem = bench.build_calibration(records, printed, STARTS[start])
    told: list[SearchNote] = []

    def tell(note: SearchNote) -> None:
        if not told or note.cost < told[-1].cost:
            told.append(note)

    fit = solve_problem(problem, method=method, starts=spread, tell=tell)
    path = [
        SearchPoint(runs, angle_rms(cost), problem.numbers(note.values))
        for (runs, cost), note in zip(fit.history, told, strict=True)
    ]
    return CalibrationSearch(fit, tuple(path))


def list_starts(full: bool) -> tuple[int, ...]:
    """From which starts coordinate search begins."""
    return ALL if full else FEW


def prepare_searches(printed: Printed, *, full: bool) -> None:
    """Make all searches, coordinate searches on two cores at once."""
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
    """Return the best fit by least squares, of those from starts that move."""
    found = (run_search(data, start, SQUARES, printed) for start in moving_starts())
    return min(found, key=lambda one: one.rms)


def end_spread(name: str, found: Iterable[CalibrationSearch]) -> float:
    """Return the spread of the ends of searches in a parameter [SI]."""
    ends = [one.fit[name] for one in found]
    return max(ends) - min(ends)
