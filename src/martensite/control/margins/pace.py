"""Bound on following a reference with ideal signals, from the fastest heating and cooling.

The plant is heated with its largest signal to the top of the reference, then cooled with its least signal. In one
period a reading rises at most as on the first path and falls at most as on the second. A reference within these bounds
can be followed, except for the time in the dead band.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np

from martensite.base.errors import InputError
from martensite.base.formats import write_difference, write_percent
from martensite.control.loop.findings import LoopFinding
from martensite.control.margins.loop_case import BEYOND, LoopCase
from martensite.control.observers.base import ESTIMATED
from martensite.kernels.c99_lanes import BLOCK
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.lanes import Lanes

BEHIND, MOSTLY = 0.05, 0.2
"""Fraction of the span of the reference that counts as late, and largest fraction of late time."""
STRETCH, STEPS = 64, 20_000
"""Steps between two tests of the target, and largest number of steps."""
Curve: TypeAlias = tuple[Numbers, Numbers]
"""Times [s] and readings."""
WAYS = (
    ("falls faster than the element cools", "Try a slower way down, a thinner wire or more cooling."),
    ("rises faster than the element heats", "Try a slower way up, or a higher signal."),
)


def check_pace(case: LoopCase) -> Iterator[LoopFinding]:
    """Check whether the reading could follow the reference with ideal signals."""
    reached = case.read(case.heating)
    sign = float(np.sign(reached[-1] - reached[0]))
    ends = float(min(sign * reached)), float(max(sign * reached))
    wanted, unit = np.clip(sign * case.reference, *ends), case.unit
    rising, falling = _compute_fastest(case, sign, wanted, ends)
    best = follow_fastest(wanted, rising, falling, case.duration / max(len(wanted) - 1, 1))
    span = max(float(np.ptp(wanted)), BEYOND * (ends[1] - ends[0]))
    for off, (times, _), (words, remedy) in zip((best - wanted, wanted - best), (falling, rising), WAYS, strict=True):
        fraction = float(np.mean(off > BEHIND * span))
        if fraction > MOSTLY:
            sentence = (
                f"The reference {words}: under the best signals the reading is more than {write_percent(BEHIND)} of "
                f"its span behind for {write_percent(fraction)} of the time, and by up to "
                f"{write_difference(float(off.max()), unit, 3)}; the whole way takes {times[-1]:.3g} s at least."
            )
            yield case.find("pace", "references", (sentence, remedy), (fraction, MOSTLY, "1"))


def find_truth(case: LoopCase) -> str:
    """Return the output of the plant that is read and controlled.

    Raises:
        InputError: the reading is not an output of the plant.
    """
    name = case.controller.measured
    mounted = case.bench.sensors.members().get(name)
    output = mounted.sees()[0] if mounted is not None else name.removeprefix(ESTIMATED)
    if output not in case.bench.plant.outputs():
        raise InputError(f"`{name}` is no output of the plant")
    return output


def _compute_fastest(case: LoopCase, sign: float, wanted: Numbers, ends: tuple[float, float]) -> tuple[Curve, Curve]:
    """Return the paths under the largest, then the least signal, between the ends of the reference."""
    slack = BEYOND * (ends[1] - ends[0])
    top = min(float(wanted.max()), ends[1] - slack)
    floor = max(min(float(wanted.min()), top - slack), ends[0] + slack)
    lanes = Lanes(case.bench.plant, BLOCK, soon=True)
    lanes.reset(case.heating.signals[:, :1])
    place = list(lanes.names).index(find_truth(case))
    up = _march_until(case, lanes, case.limits[1], lambda y: sign * y >= top, place)
    down = _march_until(case, lanes, case.limits[0], lambda y: sign * y <= floor, place)
    return (up[0], np.maximum.accumulate(sign * up[1])), (down[0], np.minimum.accumulate(sign * down[1]))


def _march_until(case: LoopCase, lanes: Lanes, signal: float, done: Callable[[Numbers], Numbers], place: int) -> Curve:
    names, dt = [one.name for one in case.bench.plant.drives()], case.bench.period / case.bench.turns
    signals = case.heating.signals[:, 0].copy()
    signals[names.index(case.drive)] = signal
    rows, some = (
        [lanes.observe(signals[:, None])[place, :1]],
        np.broadcast_to(signals[:, None], (STRETCH, len(signals), 1)),
    )
    while STRETCH * len(rows) < STEPS:
        before, outputs = lanes.state, lanes.advance(some, dt)[:, place, 0]
        stop = np.flatnonzero(done(outputs))
        if len(stop):
            lanes.state = before
            lanes.advance(some[: stop[0] + 1], dt, shown=False)
            rows.append(outputs[: stop[0] + 1])
            break
        rows.append(outputs)
    column = np.concatenate(rows)
    return dt * np.arange(len(column)), column


def follow_fastest(wanted: Numbers, rising: Curve, falling: Curve, dt: float) -> Numbers:
    """Return the path nearest to a reference, at samples dt [s] apart, within the fastest rise and fall."""
    (up, high), (down, low) = rising, falling
    path, now = np.empty(len(wanted)), float(wanted[0])
    for k, target in enumerate(wanted.tolist()):
        if target > now:
            now = min(target, max(now, float(np.interp(np.interp(now, high, up) + dt, up, high))))
        elif target < now:
            now = max(target, min(now, float(np.interp(np.interp(-now, -low, down) + dt, down, low))))
        path[k] = now
    return path
