"""Stages of a path of a material point: transformations of each leg, and the residual strain.

On every leg the fraction that changes more is followed, the whole martensite or its oriented
part. Its change is followed from 1 % over half to 99 %, between samples along straight lines.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from martensite.simulate.point import PointResult
from martensite.simulate.transformation_points import PlanePoint

LEAST_CHANGE = 0.005
"""Change of a fraction on a leg below which it does not count as a transformation."""
SHARES = (0.01, 0.5, 0.99)
STILL = {"temperature": 0.01, "stress": 1e3, "strain": 1e-7}
"""Changes below which a column does not change on a leg, in SI."""


@dataclass(frozen=True)
class PathStage:
    """One leg of a path."""

    kind: str
    """Kind of the stage, such as `loading` or `heating`; the prescribed quantities decide."""
    process: str
    """`forward`, `reverse`, `orientation` or nothing."""
    martensite: float
    """Change of the martensite fraction [-]."""
    oriented: float
    """Change of the oriented fraction [-]."""
    spots: tuple[PlanePoint, PlanePoint, PlanePoint] | None
    """Points at which the transformation starts, is half done and ends."""
    varies: tuple[str, ...]
    """Which of stress and temperature change on the leg."""
    end: PlanePoint
    strain: float
    """At the end [-]."""


def list_stages(result: PointResult) -> list[PathStage]:
    """Return every leg of a path."""
    return [_build_stage(result, leg, *span) for leg, span in enumerate(pairwise(result.ends))]


def residual_strain(result: PointResult) -> float:
    """Return the strain that a path leaves [-]: last less first."""
    return float(result.strain[-1] - result.strain[0])


def _build_stage(result: PointResult, leg: int, first: int, last: int) -> PathStage:
    changes = {n: float(result[n][last] - result[n][first]) for n in (*STILL, "martensite", "oriented")}
    martensite, oriented = changes["martensite"], changes["oriented"]
    name = "martensite" if abs(martensite) >= 0.5 * abs(oriented) else "oriented"
    varies = tuple(n for n in ("stress", "temperature") if np.ptp(result[n][first : last + 1]) > STILL[n])
    acts = abs(changes[name]) > LEAST_CHANGE
    process = "orientation"
    if name == "martensite":
        process = "forward" if martensite > 0.0 else "reverse"
    return PathStage(
        kind=_describe_kind(result, leg, changes),
        process=process if acts else "",
        martensite=martensite,
        oriented=oriented,
        spots=_find_spots(result, result[name].tolist(), first, last) if acts else None,
        varies=varies,
        end=PlanePoint(float(result.stress[last]), float(result.temperature[last])),
        strain=float(result.strain[last]),
    )


def _describe_kind(result: PointResult, leg: int, changes: dict[str, float]) -> str:
    control = result.legs[leg].control
    words: list[str] = []
    if abs(changes["temperature"]) > STILL["temperature"]:
        words.append("heating" if changes["temperature"] > 0.0 else "cooling")
    if control == "stress" and abs(changes["stress"]) > STILL["stress"]:
        words.append("loading" if changes["stress"] > 0.0 else "unloading")
    if control == "strain":
        before = [e for e in (x.strain for x in result.legs[:leg]) if e is not None]
        begin = before[-1] if before else float(result.strain[0])
        words.append("stretching" if (result.legs[leg].strain or 0.0) > begin else "releasing")
    return " and ".join(words) or "waiting"


def _find_spots(
    result: PointResult, fractions: list[float], first: int, last: int
) -> tuple[PlanePoint, PlanePoint, PlanePoint]:
    start, half, end = (_find_spot(result, fractions, first, last, share) for share in SHARES)
    return start, half, end


def _find_spot(result: PointResult, fractions: list[float], first: int, last: int, share: float) -> PlanePoint:
    """Return the point at which a fraction of the change on a leg is done."""
    begin, change = fractions[first], fractions[last] - fractions[first]
    done = [(fractions[i] - begin) / change for i in range(first, last + 1)]
    k = next(i for i, value in enumerate(done) if value >= share)
    if k == 0:
        return PlanePoint(float(result.stress[first]), float(result.temperature[first]))
    part = (share - done[k - 1]) / (done[k] - done[k - 1])
    i = first + k

    def between(column: NDArray[np.float64]) -> float:
        return float(column[i - 1] + part * (column[i] - column[i - 1]))

    return PlanePoint(between(result.stress), between(result.temperature))
