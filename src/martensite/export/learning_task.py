"""Learning task on a bench: outputs, references, bounds and reward.

    r = −min(|y* − y| / (high − low), 1) − w P T

is the reward of a period T, with the true output y, its reference y*, the electrical power P of all elements and the
weight w. For several outputs the error is their mean. The error is limited to the whole range, so idling costs at most
1 per period. An exceeded limit ends the episode; the last reward is reduced by the penalty and by 1 for each remaining
period. The default penalty is the number N of periods, so the sum is below -N: ending an episode early never pays.

Each episode draws new references and, within declared spreads, a new plant:

    p = p₀ (1 + s z),    temperatures p = p₀ + s z,    z uniform in [-1, 1]

Models in controllers and observers of the bench stay nominal.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.base.errors import InputError, ParameterError, require_known, suggest_name
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import AGE, MEASURED, list_readings
from martensite.control.loop.plant_leaves import PLANT, find_plant_leaf, parse_half_width, require_allowed

Numbers = NDArray[np.float64]
SHARES = (0.1, 0.4)
"""Default shortest and longest level of steps, as fractions of an episode."""
TURNS = (1.0, 4.0)
"""Default lowest and highest number of sine periods in an episode."""


@dataclass(frozen=True, kw_only=True)
class LearningTask:
    """Task of a learner, in SI."""

    output: str | tuple[str, ...]
    """Output of the plant that follows the reference, or several, each with a separate reference."""
    low: float
    """Lowest reference."""
    high: float
    """Highest reference."""
    duration: float
    """Length of an episode [s]."""
    signals: Mapping[str, tuple[float, float]] = field(default_factory=dict[str, Any])
    """Signal range by drive; drives in duty cycle default to 0 to 1."""
    observed: Mapping[str, tuple[float, float]] = field(default_factory=dict[str, Any])
    """Range by reading; by default the outputs, with the range of references."""
    preview: tuple[float, ...] = ()
    """Preview times of the reference [s], in addition to the present."""
    references: tuple[str, ...] = ("steps", "sines")
    """Kinds of references, drawn at random."""
    hold: tuple[float, float] | None = None
    """Shortest and longest level of steps [s]; by default 0.1 and 0.4 of an episode."""
    frequency: tuple[float, float] | None = None
    """Lowest and highest frequency of sines [Hz]; by default 1 and 4 periods in an episode."""
    spreads: Mapping[str, float] = field(default_factory=dict[str, Any])
    """Half-width by path, or unique ending of a path, in the plant: a fraction of the value, in K for temperatures."""
    energy_weight: float = 0.0
    """Cost of an electrical joule."""
    penalty: float | None = None
    """Cost of exceeding a limit, in addition to 1 for each remaining period; by default the number of periods."""
    temperature_limit: float | None = None
    """Highest temperature of any element [K]; by default the limit of each element."""
    stress_limit: float | None = None
    """Highest stress of any element [Pa]; by default the limit of each element."""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise ParameterError(f"A reference needs a range, but goes from {self.low:g} to {self.high:g}.")
        if not (math.isfinite(self.duration) and self.duration > 0.0):
            raise ParameterError(f"An episode must last above 0 s, but lasts {self.duration:g} s.")
        if not self.references:
            raise ParameterError(f"A task needs a kind of reference: {', '.join(KINDS)}.")
        for kind in self.references:
            if kind not in KINDS:
                raise ParameterError(f"No reference named `{kind}`. {suggest_name(kind, KINDS)}")
        if min(self.preview, default=0.0) < 0.0:
            raise ParameterError(f"A preview is ahead, but one is {min(self.preview):g} s.")
        if not self.outputs:
            raise ParameterError("A task needs an output that follows a reference.")

    @property
    def outputs(self) -> tuple[str, ...]:
        """Return the names of the outputs that follow a reference."""
        return (self.output,) if isinstance(self.output, str) else tuple(self.output)

    def reference(self, rng: np.random.Generator, times: Numbers) -> Numbers:
        """Return a random reference at times [s], shape (samples,)."""
        kind = self.references[int(rng.integers(len(self.references)))]
        return KINDS[kind](self, rng, times)


def _draw_steps(task: LearningTask, rng: np.random.Generator, times: Numbers) -> Numbers:
    shortest, longest = task.hold or tuple(share * task.duration for share in SHARES)
    reference, begin = np.empty_like(times), 0.0
    while begin <= times[-1]:
        level, time = rng.uniform(task.low, task.high), rng.uniform(shortest, longest)
        reference[times >= begin] = level
        begin += max(time, 1e-6 * task.duration)
    return reference


def _draw_sine(task: LearningTask, rng: np.random.Generator, times: Numbers) -> Numbers:
    slow, fast = task.frequency or tuple(turns / task.duration for turns in TURNS)
    middle = rng.uniform(task.low, task.high)
    most = min(middle - task.low, task.high - middle)
    amplitude, phase = rng.uniform(0.0, most), rng.uniform(0.0, 2.0 * math.pi)
    return middle + amplitude * np.sin(2.0 * math.pi * rng.uniform(slow, fast) * times + phase)


KINDS: dict[str, Callable[[LearningTask, np.random.Generator, Numbers], Numbers]] = {
    "steps": _draw_steps,
    "sines": _draw_sine,
}


@dataclass(frozen=True)
class EpisodeSpread:
    """A parameter of the plant that differs from episode to episode."""

    path: str
    """Path in the bench."""
    middle: float
    wide: float

    def draw(self, rng: np.random.Generator) -> float:
        """Return a random value within the spread."""
        return float(self.middle + self.wide * rng.uniform(-1.0, 1.0))


def spreads_of(bench: Bench, task: LearningTask) -> list[EpisodeSpread]:
    """Return the spreads of a task."""
    return [_check_spread(bench, name, spread) for name, spread in task.spreads.items()]


def _check_spread(bench: Bench, name: str, spread: float) -> EpisodeSpread:
    leaf = find_plant_leaf(bench, name)
    if not (math.isfinite(spread) and spread >= 0.0):
        raise ParameterError(f"The spread of `{name}` must be at least 0, but is {spread:g}.")
    wide = parse_half_width(leaf, spread)
    require_allowed(leaf, leaf.value - wide, leaf.value + wide)
    return EpisodeSpread(PLANT + leaf.path, float(leaf.value), wide)


def scale_values(values: Numbers, ranges: Sequence[tuple[float, float]]) -> Numbers:
    """Return rows of values, scaled to -1 to 1 over their ranges."""
    low, high = np.array(ranges, float).reshape(-1, 2).T[:, :, None]
    return 2.0 * (values - low) / (high - low) - 1.0


def free_signals(bench: Bench, task: LearningTask) -> dict[str, tuple[float, float]]:
    """Return the signal range of each free drive."""
    controlled = bench.controllers.members()
    free = {one.name: one.unit for one in bench.plant.drives() if one.name not in controlled}
    if not free:
        raise InputError("Every drive of this bench has a controller; leave one to the learner.")
    for name in task.signals:
        require_known("free drive", name, free)
    for name, unit in free.items():
        if name not in task.signals and unit != "1":
            raise InputError(
                f"Drive `{name}` takes a signal in {unit}: give its lowest and highest value in `signals`."
            )
    ranges = {name: task.signals.get(name, (0.0, 1.0)) for name in free}
    _require_ranges(ranges)
    return ranges


def observed_readings(bench: Bench, task: LearningTask) -> dict[str, tuple[float, float]]:
    """Return the ranges of the observations, by output of the bench."""
    readings = [name for name in list_readings(bench) if not name.endswith(AGE)]
    ranges = dict(task.observed) or dict.fromkeys(task.outputs, (task.low, task.high))
    for name in ranges:
        require_known("reading", name, readings)
    _require_ranges(ranges)
    mounted = bench.sensors.members()
    return {MEASURED + n if n in mounted else n: span for n, span in ranges.items()}


def _require_ranges(ranges: Mapping[str, tuple[float, float]]) -> None:
    for name, (low, high) in ranges.items():
        if not (math.isfinite(low) and math.isfinite(high) and low < high):
            raise InputError(f"The range of `{name}` must be one, but is {low:g} to {high:g}.")
