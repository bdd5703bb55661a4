"""All inputs of a run, in one table by name.

    p:PATH                       a parameter of the system or bench
    duration, tolerance, samples, step, mechanism, inertial, interval
                                 (a bench has one sample per period)
    low:K, high:K                bounds of the envelope
    drive:I.start:K, …           segments and tones of the waveform of a drive

A waveform of a system in discrete time is evaluated at its samples. If segments cannot represent it, as for noise, the
samples are stored.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.control.loop.run import noise_waveforms, reference_waveforms
from martensite.scenario.scenario import Scenario
from martensite.signals.base import AbstractWaveform
from martensite.signals.moments import Segment
from martensite.simulate.api import inertial_step
from martensite.simulate.compiled import CompiledMarch, compile_march
from martensite.simulate.drive_waveforms import arrange_waveforms, by_name
from martensite.simulate.envelope import envelope_of
from martensite.simulate.grid import just_after

MORE = 2
"""Ratio of the time covered by segments to the duration of a run, for variants with shorter periods."""
MOST_SEGMENTS = 2000
"""Largest number of segments of a waveform; longer ones are sampled, or not offered."""
SEGMENT = ("start", "level", "slope", "bend")
TONE = ("amplitude", "rate", "phase")
EQUALITY_TOLERANCE = 1e-12
"""Relative tolerance of equal samples of a waveform."""


@dataclass(frozen=True)
class DriveShape:
    """Shape of the waveform of a drive for the engine."""

    segments: int
    """Number of segments; 0 for stored samples."""
    tones: int


@dataclass
class FlatInputs:
    """The inputs of a run by name, with shapes and samples of its waveforms."""

    numbers: dict[str, float]
    drives: list[DriveShape]
    samples: list[NDArray[np.float64]] = field(default_factory=list[Any])
    """Sampled values of drives without segments, at each step in discrete time."""

    def digest(self) -> str:
        """Return the digest of all samples."""
        return hashlib.sha256(b"".join(one.tobytes() for one in self.samples)).hexdigest()


def list_waveforms(scenario: Scenario) -> list[AbstractWaveform]:
    """Return the waveforms of a scenario, in the order of its drives."""
    bench = scenario.bench
    if bench is None:
        return list(arrange_waveforms(scenario.system, scenario.waveform))
    played = {
        **by_name(scenario.system, scenario.waveform),
        **reference_waveforms(bench),
        **noise_waveforms(bench, scenario.duration, scenario.seed),
    }
    return list(arrange_waveforms(bench, played))


def list_inputs(scenario: Scenario, shapes: Sequence[DriveShape] | None = None) -> FlatInputs:
    """Return the inputs of a scenario, optionally in given shapes."""
    system = scenario.whole
    compiled = compile_march(system)
    scalars = dict(_list_scalars(scenario, compiled))
    interval, waves = system.sample_time(), list_waveforms(scenario)
    chosen = shapes or [_choose_shape(wave, scenario.duration, interval) for wave in waves]
    if len(chosen) != len(waves):
        raise ValueError("another number of drives")
    inputs = FlatInputs(scalars, list(chosen))
    for number, (wave, shape, drive) in enumerate(zip(waves, chosen, system.drives(), strict=True)):
        if shape.segments:
            scalars |= _list_segments(wave, shape, scenario.duration, f"drive:{number}")
        else:
            inputs.samples.append(_read_samples(wave, scenario.duration, interval, drive.ahead))
    return inputs


def _list_scalars(scenario: Scenario, compiled: CompiledMarch) -> Iterator[tuple[str, float]]:
    system = scenario.whole
    for path, value in zip(compiled.paths, compiled.values(system), strict=True):
        yield f"p:{path}", float(value)
    yield "duration", scenario.duration
    yield "tolerance", scenario.tolerance
    yield "samples", math.inf if scenario.bench is not None else float(scenario.samples)
    yield "step", scenario.step or math.inf
    yield "mechanism", system.mechanism.first_step()
    yield "inertial", inertial_step(system)
    yield "interval", system.sample_time()
    limits = envelope_of(system)
    for name, bounds in (("low", limits.low), ("high", limits.high)):
        for k, bound in enumerate(bounds):
            yield f"{name}:{k}", bound


def _choose_shape(wave: AbstractWaveform, duration: float, interval: float) -> DriveShape:
    """Return a shape with spare segments for a run; without segments if they are too many or too inaccurate."""
    fitted = type(wave).segments is AbstractWaveform.segments
    if fitted and interval > 0.0:  # parabolas through readings are no better
        return DriveShape(0, 0)
    pieces = list(islice(_list_until(wave, MORE * duration), MOST_SEGMENTS + 1))
    missed = interval > 0.0 and not _tells_readings(wave, pieces, duration, interval)
    if missed or len(pieces) > MOST_SEGMENTS:
        return DriveShape(0, 0)
    return DriveShape(len(pieces), len(wave.tones()))


def _list_until(wave: AbstractWaveform, end: float) -> Iterator[Segment]:
    """Yield the segments that begin by a time [s], and one more that ends the last of them."""
    for one in wave.segments(0.0):
        yield one
        if one.start > end:
            return


def _tells_readings(wave: AbstractWaveform, segments: Sequence[Segment], duration: float, interval: float) -> bool:
    """Return whether segments and tones reproduce a waveform at its samples."""
    times = _list_instants(duration, interval, False)
    table = np.array([tuple(one) for one in segments])
    place = np.maximum(np.searchsorted(table[:, 0], times, side="right") - 1, 0)
    along = times - table[place, 0]
    values = table[place, 1] + (table[place, 2] + table[place, 3] * along) * along
    for amplitude, rate, phase in wave.tones():
        values = values + amplitude * np.cos(rate * times + phase)
    wanted = np.array(wave.signals(times.tolist()))
    return bool(np.abs(values - wanted).max() <= EQUALITY_TOLERANCE * max(float(np.abs(wanted).max()), 1e-300))


def _list_instants(duration: float, interval: float, ahead: bool) -> NDArray[np.float64]:
    """Return the sampling times in discrete time [s]; `ahead` gives the ends of steps."""
    steps = math.floor(duration / interval + 1e-9)
    return np.array([(k + just_after(False)) * interval for k in range(steps + 1)])


def _read_samples(wave: AbstractWaveform, duration: float, interval: float, ahead: bool) -> NDArray[np.float64]:
    if not interval:
        raise ValueError("a waveform of too many segments")
    return np.array(wave.signals(_list_instants(duration, interval, ahead).tolist()))


def _list_segments(wave: AbstractWaveform, shape: DriveShape, duration: float, name: str) -> Mapping[str, float]:
    pieces = list(islice(wave.segments(0.0), shape.segments + 1))
    beyond = pieces[shape.segments :]
    if len(pieces) < shape.segments or len(wave.tones()) != shape.tones or any(one.start <= duration for one in beyond):
        raise ValueError("another number of segments or tones")
    rows = [(SEGMENT, one, k) for k, one in enumerate(pieces[: shape.segments])]
    rows += [(TONE, one, k) for k, one in enumerate(wave.tones())]
    return {f"{name}.{what}:{k}": float(x) for names, row, k in rows for what, x in zip(names, row, strict=True)}
