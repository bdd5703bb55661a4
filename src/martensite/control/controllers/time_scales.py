"""Times that full and zero signal need to move a system: a measure for the horizon."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError
from martensite.simulate.api import longest_step
from martensite.simulate.lanes import Lanes, Numbers

FIRST, DOUBLINGS = 64, 8
"""Steps of the first look, and how often it is made twice as long."""
BEGUN, HALF, MOST, SETTLED = 0.1, 0.5, 0.9, 0.01


class TimeScales(NamedTuple):
    """Times of a system [s]."""

    start: float
    """Until full signal, from rest, has made a tenth of the travel."""
    up: float
    """Until it has made half of it."""
    down: float
    """From nine tenths of it, until no signal has left half."""


def measure_reach(system: AbstractSystem, output: str, low: float, high: float) -> TimeScales:
    """Measure how long full and zero signal need to move an output.

    Args:
        system: a system with one drive.
        output: what shall move.
        low: least signal.
        high: largest signal.

    Raises:
        ParameterError: full signal does not move the output.
    """
    dt = 0.5 * longest_step(system)
    lanes = Lanes(system, 1)
    lanes.reset(low)
    index = lanes.names.index(output)
    rest = float(lanes.observe(low)[index, 0])
    up = _settle_output(lanes, high, dt, index, rest)
    top = float(up[-1])
    if not np.isfinite(top) or abs(top - rest) <= 1e-12 * max(abs(rest), 1e-9):
        raise ParameterError(f"The signal {high:g} does not move `{output}` of the model.")
    share = (up - rest) / (top - rest)
    lanes.reset(low)
    lanes.advance(np.full((_count_until(share >= MOST), 1, 1), high), dt)
    down = (_settle_output(lanes, low, dt, index, top) - rest) / (top - rest)
    return TimeScales(
        dt * _count_until(share >= BEGUN), dt * _count_until(share >= HALF), dt * _count_until(down <= HALF)
    )


def _settle_output(lanes: Lanes, signal: float, dt: float, index: int, before: float) -> Numbers:
    """Return an output under one signal until it hardly changes."""
    found = np.array([before])
    steps = FIRST
    for _ in range(DOUBLINGS):
        more = lanes.advance(np.full((steps, 1, 1), signal), dt)[:, index, 0]
        found = np.concatenate([found, more])
        steps = len(found)
        change = abs(more[-1] - more[0])
        if change <= SETTLED * np.ptp(found) and np.ptp(found) > 0.0:
            break
    return found[1:]


def _count_until(flags: NDArray[np.bool_]) -> int:
    """After how many steps flags are up for the first time; all of them, if never."""
    return 1 + int(np.argmax(flags)) if np.any(flags) else len(flags)
