"""Claims on the search: whether it ends in the minimum, its cost, and where it cannot start."""

from __future__ import annotations

from martensite.studies.base import Claim
from martensite.studies.finger_calibration.bench import FAR, NEAR, Data
from martensite.studies.finger_calibration.printed import METHOD, Printed
from martensite.studies.finger_calibration.searches import (
    COORDINATE,
    SQUARES,
    STILL,
    Search,
    best,
    moving,
    prepare,
    search,
    spread,
    tried,
)

NEAR_ENOUGH = 0.02
"""Excess of an rms over the least [°] at which a search has arrived: a fiftieth of the noise."""
MORE = 2
"""Further starts that cure one without motion."""


def claims(printed: Printed, *, full: bool) -> list[Claim]:
    """Coordinate search, least squares, and the start without motion."""
    prepare(printed, full=full)
    return [
        *(claim for data in (NEAR, FAR) for claim in _of(data, printed, tried(full))),
        *_still(printed),
    ]


def excess(data: Data, start: int, printed: Printed) -> float:
    """Rms of the end of a coordinate search above that of least squares [°]."""
    return search(data, start, COORDINATE, printed).rms - best(data, printed).rms


def _of(data: Data, printed: Printed, starts: tuple[int, ...]) -> list[Claim]:
    walked = [search(data, start, COORDINATE, printed) for start in starts]
    solved = [search(data, start, SQUARES, printed) for start in moving()]
    least = best(data, printed)
    return [
        Claim.checked(
            f"minimum-{data.key}",
            f"largest rms at the end of a coordinate search above the least, {data.name}",
            f'{METHOD}, "avoiding local minima"', 0.0, max(one.rms for one in walked) - least.rms,
            "deg", NEAR_ENOUGH,
            f"the least is {least.rms:.3f}°; coordinate search ends in {_ends(walked, starts)}: "
            "a narrow valley leads across the axes, where no short step along one axis is better",
        ),
        Claim.reported(
            f"coordinate-runs-{data.key}", f"runs of a coordinate search, {data.name}", METHOD,
            sum(one.runs for one in walked) / len(walked), "1", f"mean of {len(walked)} starts",
        ),
        Claim.reported(
            f"least-squares-runs-{data.key}", f"runs of least squares, {data.name}", METHOD,
            sum(one.runs for one in solved) / len(solved), "1",
            f"mean of {len(solved)} starts that move; of them "
            f"{sum(one.fit.jacobians for one in solved) / len(solved):.0f} with exact "
            "derivatives, which cost little more than one run",
        ),
        Claim.reported(
            f"least-squares-apart-{data.key}",
            f"how far least squares from {len(solved)} starts ends apart in dσ/dT, {data.name}",
            METHOD, spread("dsigma_dT", solved) / 1e6, "MPa/K",
            f"all end at {least.rms:.3f}°; in T_L they end {spread('T_L', solved):.1f} K apart, "
            "for which σ_L makes up",
        ),
    ]  # fmt: skip


def _ends(walked: list[Search], starts: tuple[int, ...]) -> str:
    ends = [
        f"{one.rms:.3f}° at {one.fit['dsigma_dT'] / 1e6:.2f} MPa/K (start {start + 1}, "
        f"{one.runs} runs)"
        for one, start in zip(walked, starts, strict=True)
    ]
    return ", ".join(ends)


def _still(printed: Printed) -> list[Claim]:
    caught = search(FAR, STILL, SQUARES, printed)
    walked = search(FAR, STILL, COORDINATE, printed)
    cured = search(FAR, STILL, SQUARES, printed, MORE)
    return [
        Claim.reported(
            "still", "rms of least squares from a start at which the finger does not move", METHOD,
            caught.rms, "deg",
            f"the power never reaches that wire's threshold, all derivatives are 0, and "
            f"the search ends after {caught.runs} runs; coordinate search gets away, "
            f"and ends at {walked.rms:.2f}° after {walked.runs} runs",
        ),
        Claim.reported(
            "still-starts", f"the same with {MORE} further starts", METHOD, cured.rms, "deg",
            f"the best of 64 points within the ranges; {cured.runs} runs in all, and the least of "
            f"the other starts, {best(FAR, printed).rms:.3f}°",
        ),
    ]  # fmt: skip
