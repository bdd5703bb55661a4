"""Numbers of the searches: final error, cost, and a start without motion."""

from __future__ import annotations

from typing import Any

from martensite.studies.finger_calibration.bench import FAR, NEAR, Data
from martensite.studies.finger_calibration.searches import (
    COORDINATE,
    SQUARES,
    STILL,
    CalibrationSearch,
    best_fit,
    end_spread,
    list_starts,
    moving_starts,
    prepare_searches,
    run_search,
)
from martensite.studies.tables import Printed

MORE = 2
"""Additional starts for the start without motion."""


def compute_search(printed: Printed, *, full: bool) -> dict[str, Any]:
    """Return coordinate search, least squares, and the start without motion."""
    prepare_searches(printed, full=full)
    return {
        "searches": [_list_search(data, printed, list_starts(full)) for data in (NEAR, FAR)],
        "more": MORE,
        "caught": run_search(FAR, STILL, SQUARES, printed),
        "away": run_search(FAR, STILL, COORDINATE, printed),
        "cured": run_search(FAR, STILL, SQUARES, printed, MORE),
        "least": best_fit(FAR, printed),
    }


def _list_search(data: Data, printed: Printed, starts: tuple[int, ...]) -> dict[str, Any]:
    walked = [run_search(data, start, COORDINATE, printed) for start in starts]
    solved = [run_search(data, start, SQUARES, printed) for start in moving_starts()]
    least = best_fit(data, printed).rms
    return {
        "key": data.key,
        "data": data.name,
        "excess": max(one.rms for one in walked) - least,
        "least": least,
        "ends": _word_ends(walked, starts),
        "walked": len(walked),
        "walked_runs": sum(one.runs for one in walked) / len(walked),
        "solved": len(solved),
        "solved_runs": sum(one.runs for one in solved) / len(solved),
        "jacobians": sum(one.fit.jacobians for one in solved) / len(solved),
        "slope_apart": end_spread("dsigma_dT", solved) / 1e6,
        "kelvin_apart": end_spread("T_L", solved),
    }


def _word_ends(walked: list[CalibrationSearch], starts: tuple[int, ...]) -> str:
    ends = [
        f"{one.rms:.3f}° at {one.fit['dsigma_dT'] / 1e6:.2f} MPa/K (start {start + 1}, {one.runs} runs)"
        for one, start in zip(walked, starts, strict=True)
    ]
    return ", ".join(ends)
