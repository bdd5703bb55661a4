"""Relay autotuning (Åström and Hägglund): a relay in the loop, and gains from its limit cycle.

    relay: bias + d while y < r - ε until y ≥ r + ε, then bias - d
    K_u = 4 d/(π √(a² - ε²)),       P_u = period,       a = half the range of the reading

K_u and P_u are gain and period at the limit of stability if the plant is a low pass and otherwise linear (describing
function). With hysteresis ε the phase of the plant is not -π but -π + arcsin(ε/a), so that K_u is somewhat too small. A
shape-memory actuator heats faster than it cools, or slower near the top: then the times on and off differ, the mean
signal is not the bias, and the describing function is an average; `asymmetry` is off/on.

    rule             form  K_p         T_i       T_d
    ziegler-nichols  PI    0.45 K_u    P_u/1.2
                     PID   0.6 K_u     P_u/2     P_u/8
    tyreus-luyben    PI    K_u/3.2     2.2 P_u
                     PID   K_u/2.2     2.2 P_u   P_u/6.3
    no-overshoot     PID   0.2 K_u     P_u/2     P_u/3

Sources: `astrom1984`, `ziegler1942`, `tyreus1992`, `seborg2011` (no overshoot).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import DataError, ParameterError, suggest_name
from martensite.control.controllers.relay import OnOff
from martensite.control.controllers.relay_tuning import RELAY_RULES, STEADY, find_ultimate_gain
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import name_loop_columns
from martensite.control.loop.parts import Controllers
from martensite.control.loop.run import simulate_bench
from martensite.control.rules.formulas import FORMS, IdealGains
from martensite.control.tuning.loop_runs import find_loop
from martensite.kernels import floats
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.api import longest_step

CYCLES = 6
SKIPPED = 3
DOUBLINGS = 5


class LimitCycle(NamedTuple):
    """Limit cycle of a relay test."""

    gain: float
    """K_u, signal per unit of the reading; negative if the reading falls when the signal rises."""
    period: float
    """P_u [s]."""
    amplitude: float
    """a, in the unit of the reading."""
    on: float
    """Time with the larger signal in a cycle [s]."""
    off: float
    """Time with the smaller signal [s]."""
    mean: float
    phase: float
    """Phase of the plant at this frequency [rad], between -π and -π/2."""
    scatter: float
    """Standard deviation of the periods over their mean."""
    times: Numbers
    signal: Numbers
    reading: Numbers

    @property
    def asymmetry(self) -> float:
        """Return the time off over the time on."""
        return self.off / self.on

    @property
    def steady(self) -> bool:
        """Return whether the cycles repeat."""
        return self.scatter <= STEADY


RELAY_CITES: Mapping[str, tuple[str, ...]] = {
    "ziegler-nichols": ("astrom1984", "ziegler1942"),
    "tyreus-luyben": ("astrom1984", "tyreus1992"),
    "no-overshoot": ("astrom1984", "seborg2011"),
}


def gains_by_relay(cycle: LimitCycle, rule: str = "tyreus-luyben", form: str = "pid") -> IdealGains:
    """Return the gains from a limit cycle.

    Raises:
        ParameterError: an unknown rule or form, or a rule without this form.
    """
    if rule not in RELAY_RULES:
        raise ParameterError(f"There is no relay rule `{rule}`. {suggest_name(rule, RELAY_RULES)}")
    if form not in FORMS:
        raise ParameterError(f"A rule gives `pi` or `pid`, not `{form}`. {suggest_name(form, FORMS)}")
    if form not in RELAY_RULES[rule]:
        raise ParameterError(f"Relay rule `{rule}` is for pid only.")
    Kp, Ti, Td = RELAY_RULES[rule][form]
    return IdealGains(Kp * cycle.gain, Ti * cycle.period, Td * cycle.period)


def run_relay_test(
    bench: Bench,
    level: float,
    bias: float,
    amplitude: float,
    hysteresis: float,
    *,
    drive: str | None = None,
    reverse: bool = False,
    duration: float | None = None,
    seed: int | None = 0,
    waveforms: Mapping[str, AbstractWaveform] | None = None,
) -> LimitCycle:
    """Put a relay in a loop of a bench and measure its limit cycle.

    Args:
        bench: bench with the controller that the relay replaces.
        level: mean level of the reading, in SI.
        bias: mean of the two signals.
        amplitude: d, half the difference of the signals.
        hysteresis: ε, half the dead band in the unit of the reading: a few times its noise.
        drive: drive of the loop; required for several controllers.
        reverse: whether the reading falls when the signal rises.
        duration: duration of the first run [s], doubled until there are enough cycles.
        seed: seed of noise and jitter; None for a run without noise.
        waveforms: signals of other drives of the plant.

    Raises:
        ParameterError: the loop or the relay is invalid.
        DataError: there is no limit cycle, or it is as narrow as the hysteresis.
    """
    name = find_loop(bench, drive)
    if not (amplitude > 0.0 and hysteresis >= 0.0):
        raise ParameterError(
            f"A relay needs an amplitude above 0 and a hysteresis of at least 0, but has "
            f"{amplitude:g} and {hysteresis:g}."
        )
    ready = _insert_relay(bench, name, level, bias, amplitude, hysteresis, reverse)
    length = duration or 200.0 * longest_step(bench.plant)
    for _ in range(DOUBLINGS):
        times, signal, reading = _run_relay(ready, name, length, seed, waveforms)
        turns = np.flatnonzero((signal[1:] > bias) & (signal[:-1] < bias)) + 1
        if len(turns) > CYCLES + SKIPPED:
            cycle = _measure_cycle(times, signal, reading, turns[SKIPPED:], amplitude, hysteresis)
            return cycle._replace(gain=-cycle.gain) if reverse else cycle
        length *= 2.0
    raise DataError(
        f"The relay makes no limit cycle in {0.5 * length:.4g} s: choose a level that the reading "
        f"crosses under both signals, {bias - amplitude:.4g} and {bias + amplitude:.4g}."
    )


def _insert_relay(
    bench: Bench, name: str, level: float, bias: float, d: float, hysteresis: float, reverse: bool
) -> Bench:
    members = bench.controllers.members()
    ends = (bias + d, bias - d) if reverse else (bias - d, bias + d)
    members[name] = OnOff(
        measured=members[name].measured,
        reference=Constant(level=level + hysteresis),
        band=2.0 * hysteresis,
        low=ends[0],
        high=ends[1],
    )
    return bench.with_parts(controllers=Controllers(**members))


def _run_relay(
    bench: Bench, drive: str, duration: float, seed: int | None, waveforms: Mapping[str, AbstractWaveform] | None
) -> tuple[Numbers, Numbers, Numbers]:
    run = simulate_bench(bench, duration, waveforms=waveforms, seed=seed).require()
    _, wanted, reading = name_loop_columns(bench, drive)
    return np.array(run.times), np.array(run[wanted]), np.array(run[reading])


def _measure_cycle(
    times: Numbers, signal: Numbers, reading: Numbers, turns: NDArray[np.intp], d: float, hysteresis: float
) -> LimitCycle:
    lengths = np.diff(times[turns])
    period = float(lengths.mean())
    spans = [float(np.ptp(reading[a : b + 1])) for a, b in pairwise(turns)]
    a = 0.5 * float(np.mean(spans))
    if not a > hysteresis:
        raise DataError(
            f"The limit cycle is {a:.4g} wide to either side, no wider than the hysteresis of "
            f"{hysteresis:.4g}: make the hysteresis smaller."
        )
    inside = signal[turns[0] : turns[-1]]
    fraction = float((inside > 0.5 * (inside.max() + inside.min())).mean())
    gain = find_ultimate_gain(floats, d, a, hysteresis)
    return LimitCycle(
        gain,
        period,
        a,
        fraction * period,
        (1.0 - fraction) * period,
        float(inside.mean()),
        -math.pi + math.asin(hysteresis / a),
        float(lengths.std()) / period,
        times,
        signal,
        reading,
    )
