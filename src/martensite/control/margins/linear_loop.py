"""Exact linear loop of a bench around an operating point on a branch, in discrete time.

One period of the bench with plant, sensors, delays, observers and controller is differentiated by dual numbers. With
the wanted signal u as a state,

    x_k+1 = A x_k + b u_k,    u_k+1 = c x_k + d u_k,    L(z) = -z⁻¹ (c (z I - A)⁻¹ b + d),

the loop is opened at the signal: it is stable if 1 + L has no zero outside the unit circle. Sampling, hold, delays and
filters are included; noise, rounding and signal limits are not.

The plant has a linear system for each branch (see `linearise_plant`). After a turn, within the dead band of the
hysteresis, it has a third one with a very small gain: `dead band` belongs to a point on the heating branch whose signal
falls.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from martensite.base.errors import InputError
from martensite.control.loop import period as of_period
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import NOISE, REFERENCE, list_drives, list_readings
from martensite.control.loop.parts import BenchState, Controllers, ControllerState, FaultTable, Sensors
from martensite.control.margins.linear_controller import LEAST_SIGNAL, find_reached, free_limits, settle_controller
from martensite.control.margins.margins import INSIDE
from martensite.control.synthesis.linear import PUSH, compute_slopes
from martensite.identify.chains.linear_system import LinearSystem
from martensite.kernels import floats
from martensite.kernels.nested import NestedShape, flatten_numbers, name_numbers
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.lanes import Lanes
from martensite.simulate.operating_point import SteadyPoint

Branch: TypeAlias = Literal["heating", "cooling", "dead band"]
LONG, LEAST_STEPS, MOST_STEPS = 3.0, 10, 5000
"""Longest time constants after which a step response is complete, and limits of its number of periods."""
DOUBLINGS = 40
STRETCH, STRETCHES, SETTLED = 500, 40, 1e-7
"""Periods between two tests for steady observers, number of tests, and relative change that counts as zero."""


@dataclass(frozen=True, eq=False)
class LinearLoop:
    """A loop linearised around an operating point."""

    point: SteadyPoint
    branch: Branch
    plant: LinearSystem
    """System from the signal to the controlled reading, with sensor, delay and observer."""
    loop: LinearSystem
    """L, the opened loop from the error of the signal to the signal."""
    closed: LinearSystem
    """System from reference and noise to reading and signal, one sample later."""
    reading: float
    unit: str

    @property
    def offset(self) -> float:
        """Return the reference less the reading in the steady state."""
        return float(self.closed.inputs[self.closed.input_names.index(REFERENCE)]) - self.reading


def linearise_loops(
    bench: Bench, drive: str, points: Sequence[SteadyPoint], turn: SteadyPoint | None = None
) -> list[LinearLoop]:
    """Linearise a loop around operating points of the plant.

    Args:
        bench: bench with the controller; supervisor and faults are ignored, other loops are open.
        drive: drive of the loop.
        points: steady states of the plant.
        turn: end of heating before points of the cooling branch; required with observers.

    Raises:
        InputError: the bench has no such controller, or the controller has no steady state.
    """
    isolated = _isolate_loop(bench, drive)
    states = _settle_bench(isolated, drive, points, turn)
    return [_linearise_at(isolated, drive, at, one, one.direction) for at, one in zip(states, points, strict=True)]


def linearise_dead_band(bench: Bench, drive: str, point: SteadyPoint) -> LinearLoop:
    """Linearise a loop after a turn on the heating branch, in the dead band; see `linearise_loops`."""
    isolated = _isolate_loop(bench, drive)
    (state,) = _settle_bench(isolated, drive, [point], None)
    return _linearise_at(isolated, drive, state, point, "dead band")


def _isolate_loop(bench: Bench, drive: str) -> Bench:
    """Return the bench with one loop, without supervisor and faults, and with sensors that sample in every period.

    A slower sensor gets the largest age of its reading as a delay.
    """
    members = bench.controllers.members()
    if drive not in members:
        raise InputError(f"`{drive}` has no controller.")
    sensors = {}
    for name, one in bench.sensors.members().items():
        late = max(round(one.sample_time / bench.period) - 1, 0) * bench.period
        sensors[name] = one.with_parts(sample_time=0.0, jitter=0.0, delay=one.delay + late)
    return bench.with_parts(
        controllers=Controllers(**{drive: free_limits(members[drive])}),
        supervisor=None,
        faults=FaultTable(),
        sensors=Sensors(**sensors),
        substeps=bench.turns,
    )


def _settle_bench(
    bench: Bench, drive: str, points: Sequence[SteadyPoint], turn: SteadyPoint | None
) -> list[BenchState]:
    idle = bench.with_parts(controllers=Controllers())
    start = idle.init(floats, *[0.0] * len(idle.drives()))
    if not bench.observers.members():
        return [_begin_at(idle, start, point) for point in points]
    places = [one.name for one in idle.drives()]
    lanes = Lanes(idle, len(points), soon=True)
    table = np.zeros((len(places), len(points)))
    names = [one.name for one in idle.plant.drives()]
    table[[places.index(name) for name in names]] = np.array([point.signals for point in points]).T
    lanes.reset(np.where(np.isin(places, names)[:, None], 0.0, table))
    if turn is not None:
        before = table.copy()
        cooling = [point.direction == "cooling" for point in points]
        before[places.index(drive), cooling] = turn.signal
        _hold_signals(lanes, before)
    _hold_signals(lanes, table)
    shape = NestedShape(start)
    return [shape.rebuild(column) for column in lanes.state.T.tolist()]


def _hold_signals(lanes: Lanes, table: Numbers) -> None:
    """Hold signals, shape (drives, batch), until no output changes."""
    signals, before = np.broadcast_to(table, (STRETCH, *table.shape)), lanes.observe(table)
    for _ in range(STRETCHES):
        lanes.advance(signals, 0.0, shown=False)
        now = lanes.observe(table)
        if np.all(np.abs(now - before) <= SETTLED * np.abs(now).max(axis=1, keepdims=True)):
            return
        before = now


def _begin_at(idle: Bench, start: BenchState, point: SteadyPoint) -> BenchState:
    plant = NestedShape(start.plant).rebuild(point.state.tolist())
    signals = dict(zip((one.name for one in idle.plant.drives()), point.signals, strict=True))
    truth = of_period.collect_truth(idle, floats, idle.plant, plant, signals)
    rows = zip(idle.sensors.members().values(), idle.layout()[1:], strict=True)
    return start._replace(plant=plant, sensors=tuple(one.rest(floats, truth, 0.0, count) for one, count in rows))


def collect_known(bench: Bench, xp: Any, state: BenchState, signals: Mapping[str, Any]) -> dict[str, Any]:
    """Return the readings of controllers in a state."""
    truth = {} if state.sensors else of_period.collect_truth(bench, xp, bench.plant, state.plant, signals)
    return of_period.collect_readings(bench, state.sensors, truth) | of_period.collect_estimates(bench, state.observers)


def _linearise_at(bench: Bench, drive: str, state: BenchState, point: SteadyPoint, branch: Branch) -> LinearLoop:
    controller = bench.controllers.members()[drive]
    signals = dict(zip((one.name for one in bench.plant.drives()), point.signals, strict=True))
    readings = collect_known(bench, floats, state, signals)
    memory, reference = settle_controller(controller, readings, point.signal, branch == "heating", bench.period)
    whole = state._replace(controllers=(ControllerState(point.signal, tuple(memory.tolist())),))
    flat, shape = flatten_numbers(whole), NestedShape(whole)
    place = name_numbers(whole).index("controllers.0.wanted")
    size, drives = len(flat), list_drives(bench)
    others = [signals.get(one.name, reference if one.name.startswith(REFERENCE) else 0.0) for one in drives]

    def advance(xp: Any, x: Sequence[Any]) -> list[Any]:
        after, _ = bench.step(xp, shape.rebuild(x[:size]), *x[size:], dt=bench.period)
        applied = signals | {drive: x[place]}
        return [*flatten_numbers(after), collect_known(bench, xp, after, applied)[controller.measured]]

    pushed = list(flat)
    pushed[place] += (1.0 if branch == "heating" else -1.0) * PUSH * max(abs(point.signal), LEAST_SIGNAL)
    slopes = compute_slopes(advance, [*pushed, *others])[1]
    columns = {one.name: size + k for k, one in enumerate(drives) if one.name not in signals}
    inputs, unit = slopes[:, list(columns.values())], list_readings(bench)[controller.measured].unit
    reading = readings[controller.measured]
    names, at = (
        (tuple(columns), point.drive),
        (np.array([*flat, reading]), np.array([*flat, *others])[list(columns.values())]),
    )
    parts = _split_loop(slopes[:, :size], inputs, place, bench.period, names, at)
    return LinearLoop(point, branch, *parts, reading, unit)


def _split_loop(
    slopes: Numbers,
    inputs: Numbers,
    place: int,
    period: float,
    names: tuple[tuple[str, ...], str],
    at: tuple[Numbers, Numbers],
) -> tuple[LinearSystem, LinearSystem, LinearSystem]:
    """Return plant, opened loop and closed loop from the slopes of (state, reading) by state and by inputs.

    The reading joins the state to belong to the sample of the signal. `at` is state and inputs of the operating point.
    """
    (inputs_of, drive), (state, outside), count = names, at, len(slopes)
    whole = np.hstack([slopes, np.zeros((count, 1))])
    opened, into, identity = whole.copy(), whole[:, [place]], np.eye(count)
    opened[:, place] = 0.0

    def make(a: Numbers, b: Numbers, c: Numbers, u: Numbers, of: tuple[str, ...], to: tuple[str, ...]) -> LinearSystem:
        return LinearSystem(a, b, c, np.zeros((len(c), b.shape[1])), period, u, state, c @ state, of, to)

    signal = state[[place]]
    return (
        make(opened, into, identity[[-1]], signal, (drive,), ("reading",)),
        make(opened, into, -identity[[place]], signal, ("error",), (drive,)),
        make(whole, inputs, identity[[-1, place]], outside, inputs_of, ("reading", drive)),
    )


def measure_rise(one: LinearLoop) -> float:
    """Return the time in which a step of the signal moves the reading by 63 % [s]; 0 without a response."""
    gain, times = float(one.plant.gain()[0, 0]), one.plant.time_constants()
    if gain == 0.0:
        return 0.0
    steps = int(np.clip(LONG * times[0] / one.plant.interval, LEAST_STEPS, MOST_STEPS))
    there = np.flatnonzero(one.plant.simulate(np.ones(steps))[:, 0] / gain >= 1.0 - np.exp(-1.0))
    return float(there[0]) * one.plant.interval if len(there) else float(times[0])


def measure_noise(one: LinearLoop) -> float | None:
    """Return the standard deviation of the signal by the noise of all sensors; None for an unstable loop.

    P = A P Aᵀ + B Bᵀ,    σ² = c P cᵀ
    """
    noisy = np.flatnonzero([name.startswith(NOISE) for name in one.closed.input_names])
    reached = find_reached(one.closed.a, one.closed.b[:, noisy])
    a, b, c = one.closed.a[np.ix_(reached, reached)], one.closed.b[np.ix_(reached, noisy)], one.closed.c[1, reached]
    if len(reached) and np.max(np.abs(np.linalg.eigvals(a))) >= 1.0 - INSIDE:
        return None
    covariance, power = b @ b.T, a
    for _ in range(DOUBLINGS):  # P_2k = P_k + A^k P_k (A^k)^T
        covariance, power = covariance + power @ covariance @ power.T, power @ power
    return float(np.sqrt(max(c @ covariance @ c, 0.0)))
