"""Stages of a path of a material point: transformations of each leg, and residual strain.

Each leg follows the martensite fraction or its oriented part, whichever changes more. Points at 1 %, 50 % and 99 %
of the change are interpolated linearly between samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from martensite.simulate.point import PointResult
from martensite.simulate.transformation_points import PlanePoint

LEAST_CHANGE = 0.005
"""Smallest change of a fraction on a leg that counts as a transformation."""
SHARES = (0.01, 0.5, 0.99)
STILL = {"temperature": 0.01, "stress": 1e3, "strain": 1e-7}
"""Largest changes of constant columns on a leg, in SI."""


@dataclass(frozen=True)
class PathStage:
    """Leg of a path with its transformation."""

    kind: str
    """Kind of the stage, such as `loading` or `heating`, from the prescribed quantities."""
    process: str
    """`forward`, `reverse`, `orientation` or empty."""
    martensite: float
    """Change of the martensite fraction [-]."""
    oriented: float
    """Change of the oriented fraction [-]."""
    spots: tuple[PlanePoint, PlanePoint, PlanePoint] | None
    """Points at the start, half and end of the transformation."""
    varies: tuple[str, ...]
    """Quantities that change on the leg: stress, temperature or both."""
    end: PlanePoint
    strain: float
    """At the end [-]."""


def list_stages(result: PointResult) -> list[PathStage]:
    """Return the stages of all legs of a path."""
    return [_build_stage(result, leg, *span) for leg, span in enumerate(pairwise(result.ends))]


def residual_strain(result: PointResult) -> float:
    """Return the residual strain of a path [-]: last less first."""
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
    """Return the point at a fraction of the change on a leg."""
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
