"""Frequency response at several biases: describing functions of a plant or a closed loop.

Under u = u_b + a sin ωt the output settles to a cycle. Its first harmonic over the signal,

    H(ω, u_b, a) = (2j / a T) ∫ y e^(−jωt) dt,

is the describing function (Gelb and Vander Velde 1968, ch. 3). It is the frequency response of a linear system. With
hysteresis it depends on the bias, the amplitude and the history. The remaining harmonics are the distortion.

The drive of a plant gives the open loop, the drive `reference` of a bench the closed loop. A sampled system is
evaluated at its samples, and its frequencies are rounded to whole numbers of samples per period.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import InputError
from martensite.design.sweep.driven_lanes import DrivenLanes, require_positive
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.operating_point import find_operating_point

SAMPLES = 128
"""Smallest number of steps in a period of a plant in continuous time."""
LEAST_SAMPLES = 8
"""Smallest number of samples in a period of a system in discrete time."""
SETTLED = 1e-4
"""Change from cycle n to cycle 2n of a settled output, relative to the amplitude or the smallest range."""
MOST_STEPS = 10_000
"""Largest number of steps at one frequency; four cycles are always run."""
HALF_POWER = math.sqrt(0.5)


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Gains and phases, in arrays of shape (biases, frequencies)."""

    drive: str
    output: str
    units: tuple[str, str]
    """SI units of drive and output."""
    biases: Numbers
    """Mean signals, shape (biases,)."""
    amplitude: float
    """Amplitude of the signal."""
    frequencies: Numbers
    """Simulated frequencies [Hz], shape (frequencies,)."""
    response: Any
    """Complex first harmonic of the output over the signal."""
    mean: Numbers
    """Mean output over a cycle."""
    distortion: Numbers
    """Rms of the higher harmonics over rms of the first harmonic."""
    settled: Any
    """False if cycles still changed at the end."""

    @property
    def gain(self) -> Numbers:
        """Return the amplitude of the output over the amplitude of the signal."""
        return np.abs(self.response)

    @property
    def phase(self) -> Numbers:
        """Return the phase lead of the output [rad], continuous along frequency."""
        return np.unwrap(np.angle(self.response), axis=1)

    @property
    def bandwidth(self) -> Numbers:
        """Return the frequency [Hz] at which the gain is 1/√2 of the gain at the lowest frequency, by bias.

        It is interpolated on logarithmic scales, and NaN if the gain never falls so low.
        """
        return np.array([_find_bandwidth(self.frequencies, row) for row in self.gain])


class _Cycle(NamedTuple):
    """Results of a cycle, in arrays of shape (lanes,)."""

    harmonic: Any
    mean: Numbers
    distortion: Numbers


def measure_frequency_response(
    system: AbstractSystem,
    biases: Sequence[float] | Numbers,
    amplitude: float,
    frequencies: Sequence[float] | Numbers,
    *,
    drive: str | None = None,
    output: str | None = None,
    high: float | None = None,
    native: bool | None = None,
) -> FrequencyResponse:
    """Return the frequency response by sines about several biases, run until their cycles repeat.

    Args:
        system: a plant, a model as a plant, or a bench.
        biases: mean signals, in the unit of the drive.
        amplitude: amplitude of the sines.
        frequencies: requested frequencies [Hz].
        drive: driven signal, by default the first; `reference` closes the loop of a bench.
        output: evaluated output, by default the first coordinate of the mechanism.
        high: signal of the steady state before the bias, for the cooling branch; by default each bias is reached from
            the cold.
        native: run in C, by default if there is a compiler.

    Raises:
        InputError: a name is unknown, a number is not above 0, or a frequency is too high.
        SolveError: a run failed.
    """
    wanted = require_positive("frequencies", frequencies, "Hz")
    require_positive("amplitude", amplitude, "of the drive")
    middles = np.atleast_1d(np.asarray(biases, float))
    lanes = DrivenLanes(system, len(middles), drive, output, native=native)
    start_state = None if high is None else _rest_after_cooling(lanes, middles, high)
    counts = [_count_steps(lanes, float(f)) for f in wanted]
    runs: list[tuple[_Cycle, Any]] = []
    for samples, dt in counts:
        lanes.reset(middles)
        if start_state is not None:
            lanes.lanes.state = start_state.copy()
        runs.append(_repeat_cycle(lanes, middles, amplitude, samples, dt))
    cycles = [cycle for cycle, _ in runs]
    outputs, signals = system.outputs(), {one.name: one.unit for one in system.drives()}
    return FrequencyResponse(
        lanes.drive,
        lanes.output,
        (signals[lanes.drive], outputs[lanes.output].unit),
        middles,
        amplitude,
        np.array([1.0 / (n * dt) for n, dt in counts]),
        np.array([one.harmonic for one in cycles]).T,
        np.array([one.mean for one in cycles]).T,
        np.array([one.distortion for one in cycles]).T,
        np.array([settled for _, settled in runs]).T,
    )


def _count_steps(lanes: DrivenLanes, frequency: float) -> tuple[int, float]:
    """Return the steps in a period, and their length [s]."""
    if not lanes.interval:
        samples = max(SAMPLES, math.ceil(1.0 / (frequency * lanes.step(math.inf)) - 1e-9))
        return samples, 1.0 / (frequency * samples)
    samples = round(1.0 / (frequency * lanes.interval))
    if samples < LEAST_SAMPLES:
        raise InputError(
            f"A frequency of {frequency:g} Hz has fewer than {LEAST_SAMPLES} samples of "
            f"{lanes.interval:g} s in a period; the highest is "
            f"{1.0 / (LEAST_SAMPLES * lanes.interval):.6g} Hz."
        )
    return samples, lanes.interval


def _rest_after_cooling(lanes: DrivenLanes, middles: Numbers, high: float) -> Numbers:
    """Return the steady states on the cooling branch, shape (states, lanes)."""
    given: Any = {"direction": "cooling", "high": high, "drive": lanes.drive}
    points = [find_operating_point(lanes.system, float(level), **given) for level in middles]
    return np.stack([point.state for point in points], axis=1)


def _repeat_cycle(
    lanes: DrivenLanes, middles: Numbers, amplitude: float, samples: int, dt: float
) -> tuple[_Cycle, Any]:
    """Return the last cycle, and true for each lane that has settled."""
    points = np.arange(samples + 1.0) if lanes.interval else np.arange(samples) + 0.5
    turns = points / samples
    levels = middles + amplitude * np.sin(2.0 * np.pi * turns)[:, None]
    least = max(lanes.system.convergence_scales().get(lanes.output, 0.0) / amplitude, 1e-300)
    before = _run_cycle(lanes, levels, amplitude, dt)
    done, settled = 1, np.zeros(len(middles), bool)
    while done < 4 or 2 * done * samples <= MOST_STEPS:
        for _ in range(done - 1):
            lanes.run(levels, dt)
        now = _run_cycle(lanes, levels, amplitude, dt)
        size = np.maximum(np.abs(now.harmonic), least)
        moved = np.abs(now.harmonic - before.harmonic) / size
        drift = np.abs(now.mean - before.mean) / (size * amplitude)
        settled = np.maximum(moved, drift) <= SETTLED
        if settled.all():
            return now, settled
        before, done = now, 2 * done
    return before, settled


def _run_cycle(lanes: DrivenLanes, levels: Numbers, amplitude: float, dt: float) -> _Cycle:
    """Run one more cycle."""
    y = lanes.run(levels, dt)
    samples = len(y)
    angles = 2.0 * np.pi * np.arange(1, samples + 1) / samples
    first = 2.0 / samples * (np.exp(-1j * angles) @ y)
    mean = y.mean(axis=0)
    rest = y - mean - (first * np.exp(1j * angles)[:, None]).real
    size = np.maximum(np.abs(first) / math.sqrt(2.0), 1e-300)
    # a sine held at mid-step is smaller than at its samples
    factor = 1.0 if lanes.interval else float(np.sinc(1.0 / samples))
    return _Cycle(1j * first / (amplitude * factor), mean, np.sqrt((rest**2).mean(axis=0)) / size)


def _find_bandwidth(frequencies: Numbers, gains: Numbers) -> float:
    """Return the frequency [Hz] at which gains first fall below 1/√2 of the first gain."""
    order = np.argsort(frequencies)
    f, g = np.log(frequencies[order]), np.log(np.maximum(gains[order], 1e-300))
    level = g[0] + math.log(HALF_POWER)
    below = np.flatnonzero(g < level)
    if not len(below) or below[0] == 0:
        return math.nan
    k = int(below[0])
    share = (level - g[k - 1]) / (g[k] - g[k - 1])
    return float(np.exp(f[k - 1] + share * (f[k] - f[k - 1])))
