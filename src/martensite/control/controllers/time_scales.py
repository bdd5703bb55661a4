"""Times in which full and zero signal move a system, for the choice of a horizon."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import ParameterError
from martensite.simulate.api import longest_step
from martensite.simulate.lanes import Lanes, Numbers

FIRST, DOUBLINGS = 64, 8
"""Steps of the first simulation, and number of doublings."""
BEGUN, HALF, MOST, SETTLED = 0.1, 0.5, 0.9, 0.01


class TimeScales(NamedTuple):
    """Response times of a system [s]."""

    start: float
    """Until full signal has made a tenth of the travel from the steady state."""
    up: float
    """Until it has made half of the travel."""
    down: float
    """From nine tenths of the travel, until zero signal has left half."""


def measure_reach(system: AbstractSystem, output: str, low: float, high: float) -> TimeScales:
    """Measure the time in which full and zero signal move an output.

    Args:
        system: system with one drive.
        output: name of the output.
        low: least signal.
        high: largest signal.

    Raises:
        ParameterError: full signal does not move the output.
    """
    dt = 0.5 * longest_step(system)
    lanes = Lanes(system, 1, soon=True)
    lanes.reset(low)
    index = lanes.names.index(output)
    rest = float(lanes.observe(low)[index, 0])
    up = _settle_output(lanes, high, dt, index, rest)
    top = float(up[-1])
    if not np.isfinite(top) or abs(top - rest) <= 1e-12 * max(abs(rest), 1e-9):
        raise ParameterError(f"The signal {high:g} does not move `{output}` of the model.")
    fraction = (up - rest) / (top - rest)
    lanes.reset(low)
    lanes.advance(np.full((_count_until(fraction >= MOST), 1, 1), high), dt)
    down = (_settle_output(lanes, low, dt, index, top) - rest) / (top - rest)
    return TimeScales(
        dt * _count_until(fraction >= BEGUN), dt * _count_until(fraction >= HALF), dt * _count_until(down <= HALF)
    )


def _settle_output(lanes: Lanes, signal: float, dt: float, index: int, before: float) -> Numbers:
    values = np.array([before])
    steps = FIRST
    for _ in range(DOUBLINGS):
        more = lanes.advance(np.full((steps, 1, 1), signal), dt)[:, index, 0]
        values = np.concatenate([values, more])
        steps = len(values)
        change = abs(more[-1] - more[0])
        if change <= SETTLED * np.ptp(values) and np.ptp(values) > 0.0:
            break
    return values[1:]


def _count_until(flags: NDArray[np.bool_]) -> int:
    """Return the number of steps until the first flag; the length if there is none."""
    return 1 + int(np.argmax(flags)) if np.any(flags) else len(flags)
