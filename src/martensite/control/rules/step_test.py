"""Step test on a bench: the loop is opened, the signal steps up and back, and models are fitted.

    signal u₀ → u₀ + Δ → u₀, each for some time
    y(t) = y₀ + K Δ (1 - e^(-(t - L)/T))  for t > L          first order with dead time
    y(t) = y₀ + k' Δ (t - L)              for t > L          integrating

Models of first order are fitted to the step up (heating) and to the step back (cooling), by least squares over K, T and
L, with K in closed form: a grid, then the method of Nelder and Mead. The integrating model is the line through the
response between a tenth and a half of its change. Heating and cooling of a shape-memory actuator differ, and a step
smaller than the hysteresis has hardly an effect on its way back. `find_holding_signals` finds the signals that hold a
level on both branches: a step must extend beyond both.

The response is the reading of the controller with its lag, delay and noise.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from importlib import import_module
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from martensite.base.errors import DataError, ParameterError
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import name_loop_columns
from martensite.control.loop.run import open_loop, simulate_bench
from martensite.control.rules.formulas import FirstOrder, Integrating
from martensite.control.tuning.loop_runs import find_loop
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.signals.sampling.sampled import Numbers
from martensite.signals.staircase import Staircase
from martensite.simulate.api import longest_step

QUIET = 6.0
"""Least change of a response over the standard deviation of its noise."""


class Response(NamedTuple):
    """Models of the response to one step."""

    first_order: FirstOrder
    integrating: Integrating
    fit: float


def fit_first_order(reading: Numbers, before: int, period: float, step: float) -> Response:
    """Return the models of the response to a step of the signal.

    Args:
        reading: samples of the response.
        before: number of samples before the step.
        period: sample period [s].
        step: step of the signal.

    Raises:
        DataError: the output does not respond.
    """
    start = float(reading[: before + 1].mean())
    y = np.asarray(reading[before:]) - start
    t = period * np.arange(len(y))
    noise = float(np.std(np.diff(reading))) / math.sqrt(2.0)
    if not np.abs(y).max() > max(QUIET * noise, 1e-12 * (1.0 + abs(start))):
        raise DataError(
            f"The output moves by {np.abs(y).max():.3g} only after a step of {step:g} of the "
            f"signal: take another bias, a larger step or more time."
        )
    T, L = _search_times(t, y)
    gain, error = _fit_gain(t, y, T, L)
    fit = 100.0 * (1.0 - math.sqrt(error / float(((y - y.mean()) ** 2).sum())))
    return Response(FirstOrder(gain / step, T, L), _fit_line(t, y, step), fit)


def _fit_gain(t: Numbers, y: Numbers, T: float, L: float) -> tuple[float, float]:
    """Return the best gain for a time constant and a dead time, and the remaining squares."""
    shape = -np.expm1(-np.maximum(t - L, 0.0) / T)
    gain = float(shape @ y / max(float(shape @ shape), 1e-300))
    return gain, float(((y - gain * shape) ** 2).sum())


def _search_times(t: Numbers, y: Numbers) -> tuple[float, float]:
    """Return time constant and dead time of least squares: a grid, then a local search."""
    end, least = float(t[-1]), float(t[1])
    grid = [
        (T, L)
        for T in np.geomspace(0.2 * least, 2.0 * end, 30).tolist()
        for L in np.linspace(0.0, 0.5 * end, 30).tolist()
    ]
    T, L = min(grid, key=lambda pair: _fit_gain(t, y, *pair)[1])
    result: Any = import_module("scipy.optimize").minimize(
        lambda x: _fit_gain(t, y, math.exp(x[0]), abs(x[1]))[1] / float(y @ y),
        (math.log(T), L),
        method="Nelder-Mead",
        options={
            "xatol": 1e-6,
            "fatol": 1e-12,
            "maxiter": 400,
            "initial_simplex": ((math.log(T), L), (math.log(T) + 0.3, L), (math.log(T), L + least)),
        },
    )
    return math.exp(result.x[0]), abs(float(result.x[1]))


def _fit_line(t: Numbers, y: Numbers, step: float) -> Integrating:
    way = float(y[np.argmax(np.abs(y))])
    progress = y / way
    last = max(int(np.argmax(progress >= 0.5)), 1)
    first = min(int(np.argmax(progress >= 0.1)), last - 1)
    rows: Sequence[int] = range(max(first - 1, 0), last + 1)
    slope, start = np.polyfit(t[rows], y[rows], 1)
    return Integrating(float(slope) / step, max(-float(start) / float(slope), 0.0))


Waveforms = Mapping[str, AbstractWaveform]
CONSTANTS = 8.0
"""Thermal time constants at each level by default."""
TRIED = 17
"""Number of signals in the search for holding signals."""


class StepTest(NamedTuple):
    """A step up and back."""

    heating: Response
    """Response to the step up."""
    cooling: Response
    """Response to the step back."""
    times: Numbers
    """Times since the start of the bias [s]."""
    signal: Numbers
    reading: Numbers
    bias: float
    step: float
    hold: float
    """Time at each level [s]."""

    def model(self, which: str = "mean") -> FirstOrder:
        """Return the model of heating, of cooling, or their geometric mean."""
        up, down = self.heating.first_order, self.cooling.first_order
        if which == "mean":
            sign = math.copysign(1.0, up.gain)
            return FirstOrder(
                sign * math.sqrt(abs(up.gain * down.gain)),
                math.sqrt(up.time_constant * down.time_constant),
                math.sqrt(up.dead_time * down.dead_time),
            )
        if which not in ("heating", "cooling"):
            raise ParameterError(f"A step test has models of heating, cooling and their mean, not `{which}`.")
        return up if which == "heating" else down


def run_step_test(
    bench: Bench,
    bias: float,
    step: float,
    *,
    drive: str | None = None,
    hold: float | None = None,
    seed: int | None = 0,
    waveforms: Waveforms | None = None,
) -> StepTest:
    """Step the signal of a drive up and back.

    Args:
        bench: bench with the controller whose reading is recorded; the loop is opened.
        bias: signal before and after.
        step: change of the signal.
        drive: drive of the loop; required for several controllers.
        hold: time at each level [s]; default: eight thermal time constants.
        seed: seed of noise and jitter; None for a run without noise.
        waveforms: signals of other drives of the plant.

    Raises:
        ParameterError: the loop does not exist, there is no step, or the time is too short.
        DataError: the output does not respond.
    """
    name = find_loop(bench, drive)
    time = _choose_hold(bench, hold)
    if step == 0.0 or time < 10.0 * bench.period:
        raise ParameterError("A step test needs a step, and ten periods of time for it at least.")
    wave = Staircase(first=bias, increment=step, hold=time, count=2, direction="up-down")
    times, reading = _simulate_reading(bench, name, wave, 3.0 * time, seed, waveforms)
    signal = np.array([wave.value(float(t) + 1e-9) for t in times])
    places = [round(k * time / bench.period) for k in (1, 2, 3)]
    responses = [
        fit_first_order(reading[a - 5 : b + 1], 5, bench.period, change)
        for (a, b), change in zip(pairwise(places), (step, -step), strict=True)
    ]
    return StepTest(responses[0], responses[1], times, signal, reading, bias, step, time)


class HoldingSignals(NamedTuple):
    """Signals that hold a reading at a level."""

    heating: float
    cooling: float
    """Signal on the cooling branch from the largest signal."""

    @property
    def bias(self) -> float:
        """Return the mean of both."""
        return 0.5 * (self.heating + self.cooling)

    @property
    def width(self) -> float:
        """Return the difference of both, the width of the hysteresis."""
        return abs(self.heating - self.cooling)


def find_holding_signals(
    bench: Bench,
    level: float,
    low: float,
    high: float,
    *,
    drive: str | None = None,
    hold: float | None = None,
    waveforms: Waveforms | None = None,
) -> HoldingSignals:
    """Return the signals that hold a reading at a level, from runs at constant signals.

    Args:
        bench: bench with the controller whose reading is recorded.
        level: level of the reading, in SI.
        low: least signal.
        high: largest signal, with which cooling begins.
        drive: drive of the loop; required for several controllers.
        hold: time at each signal [s].
        waveforms: signals of other drives of the plant.

    Raises:
        ParameterError: no signal between `low` and `high` holds the level.
    """
    name, time = find_loop(bench, drive), _choose_hold(bench, hold)
    signals = np.linspace(low, high, TRIED)
    branches: list[list[AbstractWaveform]] = [
        [Constant(level=u) for u in signals.tolist()],
        [Staircase(first=high, increment=u - high, hold=time, count=2) for u in signals.tolist()],
    ]
    cut = " Its supervisor may have cut the signal." if bench.supervisor is not None else ""
    ends = [
        np.array([_simulate_reading(bench, name, w, k * time, None, waveforms)[1][-1] for w in waves])
        for k, waves in enumerate(branches, start=1)
    ]
    return HoldingSignals(*(_find_crossing(signals, readings, level, cut) for readings in ends))


def _find_crossing(signals: Numbers, readings: Numbers, level: float, cut: str) -> float:
    beyond = np.flatnonzero(np.diff(np.sign(readings - level)) != 0.0)
    if not len(beyond):
        raise ParameterError(
            f"No signal from {signals[0]:g} to {signals[-1]:g} holds the reading at {level:.6g}; "
            f"it goes from {readings.min():.6g} to {readings.max():.6g}.{cut}"
        )
    k = int(beyond[0])
    fraction = (level - readings[k]) / (readings[k + 1] - readings[k])
    return float(signals[k] + fraction * (signals[k + 1] - signals[k]))


def _choose_hold(bench: Bench, hold: float | None) -> float:
    """Return the time at a level [s], a whole number of periods."""
    wanted = CONSTANTS * 10.0 * longest_step(bench.plant) if hold is None else hold
    return max(round(wanted / bench.period), 1) * bench.period


def _simulate_reading(
    bench: Bench, drive: str, wave: AbstractWaveform, duration: float, seed: int | None, waveforms: Waveforms | None
) -> tuple[Numbers, Numbers]:
    free, _ = open_loop(bench, drive)
    played = {**(waveforms or {}), drive: wave}
    run = simulate_bench(free, duration, waveforms=played, seed=seed).require()
    return np.array(run.times), np.array(run.columns[name_loop_columns(bench, drive)[2]])
