"""Stand-alone operation of a firmware: how it arms itself, and the reference that it follows.

A reference is a polyline over samples, which repeats with the duration of the scenario. Jumps take one sample.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import InputError
from martensite.boards.firmware.boards import Board, list_boards
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import list_references
from martensite.control.loop.run import reference_waveforms

if TYPE_CHECKING:
    from martensite.simulate.result import Result

STARTS = ("pin", "power-up")
"""Ways of arming without a host, in the order of `APP_ALONE` from 1 on."""
TOLERANCE = 1e-3
"""Largest distance of a polyline from its reference, over the span of the reference."""
MOST_POINTS = 400
"""Largest number of points of all references; 8 bytes of flash each."""
CLOSE = 0.05
"""Distance to the reference that counts as following, over the span of the reference."""


@dataclass(frozen=True)
class StandAlone:
    """Operation without a host."""

    start: str
    """`pin` or `power-up`."""
    samples: int
    """Samples of a cycle."""
    tracks: tuple[tuple[tuple[int, float], ...], ...]
    """Points of each input of the loop that the host would set: sample and value."""
    follows: float | None
    """Time from a cold start until the loop is close to its reference [s]; None if it never is."""


def plan_alone(
    start: str | None, board: Board, bench: Bench, duration: float, names: list[str], run: Result
) -> StandAlone | None:
    """Return the stand-alone operation of a loop; None without one.

    Args:
        start: `pin`, `power-up`, or None.
        board: the board.
        bench: the loop.
        duration: duration of a cycle [s].
        names: inputs of the loop that the host would set.
        run: run of the scenario.

    Raises:
        InputError: the way of arming or the board is not available, or an input has no reference or too many points.
    """
    if start is None:
        return None
    if start not in STARTS:
        raise InputError(f"`--stand-alone` takes {' or '.join(STARTS)}, not `{start}`.")
    if board.arm_pin is None:
        able = ", ".join(one.name for one in list_boards().values() if one.arm_pin is not None)
        raise InputError(f"`--stand-alone` is available for {able}; {board.title} keeps no calibration without a host.")
    waveforms, samples = reference_waveforms(bench), round(duration / bench.period)
    missing = [name for name in names if name not in waveforms]
    if missing:
        raise InputError(f"`--stand-alone` needs a reference for every input, but `{missing[0]}` comes from the host.")
    times = bench.period * np.arange(samples + 1)
    levels = [np.array([waveforms[name].value(float(t)) for t in times]) for name in names]
    tracks = tuple(simplify_track(one) for one in levels)
    if sum(map(len, tracks)) > MOST_POINTS:
        raise InputError(
            f"The reference needs {sum(map(len, tracks))} points, but the flash takes {MOST_POINTS}: choose a shorter "
            "`duration` or a reference of fewer steps."
        )
    return StandAlone(start, samples, tracks, _find_following(bench, run))


def simplify_track(levels: NDArray[np.float64]) -> tuple[tuple[int, float], ...]:
    """Return the points of a polyline through samples, with an error of at most `TOLERANCE` of the span."""
    room = TOLERANCE * float(np.ptp(levels)) + 1e-12
    corners, open_parts = {0, len(levels) - 1}, [(0, len(levels) - 1)]
    while open_parts:
        first, last = open_parts.pop()
        if last - first < 2:
            continue
        line = np.interp(np.arange(first, last + 1), (first, last), (levels[first], levels[last]))
        far = np.abs(levels[first : last + 1] - line)
        worst = first + int(np.argmax(far))
        if far[worst - first] > room:
            corners.add(worst)
            open_parts += [(first, worst), (worst, last)]
    return tuple((k, float(levels[k])) for k in sorted(corners))


def _find_following(bench: Bench, run: Result) -> float | None:
    """Return the first time at which all controlled readings are close to their references."""
    close = np.ones(len(run.times), dtype=bool)
    for name, one in zip(list_references(bench), bench.controllers.members().values(), strict=True):
        if one.measured not in run.columns or name not in run.columns:
            return None
        wanted = np.asarray(run.columns[name])
        close &= np.abs(np.asarray(run.columns[one.measured]) - wanted) <= CLOSE * np.ptp(wanted)
    return float(run.times[int(np.argmax(close))]) if close.any() else None


def print_reference(alone: StandAlone) -> str:
    """Return the text of `reference.h`."""
    firsts = [sum(map(len, alone.tracks[:k])) for k in range(len(alone.tracks))]
    points = [point for track in alone.tracks for point in track]
    rows = [
        "/* References of the scenario as polylines over samples, printed by martensite. */",
        "#ifdef ALONE_TABLES",
        "typedef struct {",
        "    uint32_t sample;",
        "    float value;",
        "} alone_point;",
        f"static const uint16_t alone_first[] IN_FLASH = {{{', '.join(map(str, firsts))}}};",
        "static const alone_point alone_points[] IN_FLASH = {",
        *(f"    {{{sample}UL, {np.float32(value):.9e}f}}," for sample, value in points),
        "};",
        "#endif",
        "",
    ]
    return "\n".join(rows)
