"""Records of the bench: duty cycle in, temperature and position out, at 500 Hz, in SI units.

The duty cycle of a row acts after its reading until the next. Each record begins at the steady state, with two seconds
without power. Records like the paper's are pulses; the slow record has ramps. Sealed records are random ramps with
nested minor loops; no model, start or gain was chosen with them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from martensite.base.errors import ParameterError
from martensite.control.sensors.base import Numbers
from martensite.signals.sampling.sampled import Sampled
from martensite.studies.hammerstein_wiener.bench import INTERVAL, ReferenceBench, RunningBench

LEAD = 2.0
"""Time without power before the excitation [s]."""
PULSES = (
    (18, 9, 13),
    (22, 8, 20),
    (26, 7, 14),
    (30, 6, 24),
    (36, 4.5, 15),
    (30, 5.5, 12),
    (24, 7, 22),
    (20, 8.5, 14),
    (28, 6, 25),
    (34, 4.5, 12),
    (22, 7.5, 20),
    (32, 5, 14),
)
"""Pulses of the estimation record: duty cycle [%], time on [s], time off [s]."""
OTHER_PULSES = ((20, 8, 12), (27, 6.5, 22), (33, 5, 13), (23, 7, 20), (38, 4, 15), (25, 7, 24), (29, 6, 14))
RAMPS = ((6, 20), (13, 60), (8, 50), (11, 30), (7, 40), (14, 50), (5, 60))
"""Slow record: first level [%] and its duration [s], then final level and duration of each ramp."""
HOLD, IDLE = 20.0, 60.0
"""Durations of a sealed record on its first level, and without power at its end [s]."""
FEWEST, MOST = 6, 10
"""Range of the number of ramps of a sealed record."""
LENGTH = (300.0, 600.0)
"""Range of the length of a sealed record [s]."""
RATES = (0.05, 0.3)
"""Range of the rates of its ramps [%/s]."""
LEVELS = (5.0, 15.0)
"""Range of the levels of its turning points [%]."""
LEAST_TRAVEL = 1.0
"""Smallest distance of turning points [%]."""
TRIES = 10_000


@dataclass(frozen=True, eq=False)
class Excitation:
    """A duty cycle over time."""

    name: str
    duty: Numbers
    """One value per sample, 0 to 1."""
    seed: int
    """Seed of the sensor noise."""

    def scaled(self, factor: float) -> Excitation:
        """Return the duty cycles times a factor, at most 1."""
        return Excitation(self.name, np.minimum(factor * self.duty, 1.0), self.seed)


def parse_pulses(name: str, rows: tuple[tuple[float, float, float], ...], seed: int) -> Excitation:
    """Return pulses given as (duty cycle [%], time on [s], time off [s])."""
    parts = [(level, time) for duty, on, off in rows for level, time in ((duty, on), (0.0, off))]
    counts = [round(time / INTERVAL) for _, time in parts]
    return Excitation(name, _add_lead(np.repeat([0.01 * level for level, _ in parts], counts)), seed)


def parse_ramps(name: str, rows: tuple[tuple[float, float], ...], seed: int) -> Excitation:
    """Return a level (level [%], time [s]) followed by ramps to levels in times."""
    times = np.cumsum([0.0, *(time for _, time in rows)])
    levels = [rows[0][0], *(level for level, _ in rows)]
    count = round(times[-1] / INTERVAL)
    return Excitation(name, _add_lead(0.01 * np.interp(INTERVAL * np.arange(count), times, levels)), seed)


def _add_lead(duty: Numbers) -> Numbers:
    return np.concatenate([np.zeros(round(LEAD / INTERVAL)), duty])


def estimation_duty() -> Excitation:
    """Return 283.5 s of pulses similar to the paper's record."""
    return parse_pulses("estimation", PULSES, 1)


def validation_duty() -> Excitation:
    """Return 163.5 s of other pulses."""
    return parse_pulses("validation", OTHER_PULSES, 2)


def slow_duty() -> Excitation:
    """Return 310 s of ramps with a nested minor loop, always with power."""
    return parse_ramps("slow", RAMPS, 9)


def sealed_duty(seed: int) -> Excitation:
    """Return random ramps followed by a pause without power, 300 to 600 s in all.

    There are 6 to 10 ramps between 5 and 15 % at 0.05 to 0.3 %/s. Two rates differ by at least a factor of 3, and at
    least two minor loops are nested.
    """
    if seed < 0:
        raise ParameterError(f"The seed of a sealed record must be at least 0, but is {seed}.")
    rng = np.random.default_rng(seed)
    for _ in range(TRIES):
        count = int(rng.integers(FEWEST, MOST + 1))
        turns = [rng.uniform(5.0, 7.0), *rng.uniform(LEVELS[0], LEVELS[1], count)]
        rates = np.exp(rng.uniform(math.log(RATES[0]), math.log(RATES[1]), count))
        times = [abs(b - a) / rate for (a, b), rate in zip(pairwise(turns), rates, strict=True)]
        whole = HOLD + sum(times) + IDLE
        varied = rates.max() >= 3.0 * rates.min()
        if way_turns(turns) and count_minor_loops(turns) >= 2 and varied and LENGTH[0] <= whole <= LENGTH[1]:
            rows = ((turns[0], HOLD), *zip(turns[1:], times, strict=True))
            excitation = parse_ramps(f"sealed {seed}", rows, seed)
            idle = np.zeros(round(IDLE / INTERVAL))
            return Excitation(excitation.name, np.concatenate([excitation.duty, idle]), seed)
    raise ParameterError(f"No sealed record was found for seed {seed}; try another one.")


def way_turns(levels: list[float]) -> bool:
    """Return whether a path reverses at each level, with sufficient distances."""
    ways = np.diff(levels)
    return bool(np.all(np.abs(ways) >= LEAST_TRAVEL) and np.all(ways[1:] * ways[:-1] < 0.0))


def count_minor_loops(levels: list[float]) -> int:
    """Return the number of minor loops of a path: legs within the leg two before."""
    count = 0
    for a, b, c, d in zip(levels, levels[1:], levels[2:], levels[3:], strict=False):
        count += min(a, b) < min(c, d) and max(c, d) < max(a, b)
    return count


def record_bench(excitation: Excitation, bench: ReferenceBench | None = None) -> Sampled:
    """Return the record of the bench under an excitation."""
    plant = RunningBench(bench or ReferenceBench(), excitation.seed)
    rows: list[tuple[float, float]] = []
    for duty in excitation.duty.tolist():
        rows.append(plant.measured())
        plant.step(duty)
    return Sampled(
        excitation.name,
        INTERVAL,
        excitation.duty,
        np.array(rows),
        ("duty",),
        ("temperature", "position"),
        {"duty": "1", "temperature": "K", "position": "m"},
    )


def split_stages(whole: Sampled) -> tuple[Sampled, Sampled]:
    """Return the two stages of a record: duty cycle to temperature, and temperature to position."""
    temperature, position = whole.outputs[:, :1], whole.outputs[:, 1:]
    units = dict(whole.units)
    return (
        Sampled(
            f"{whole.name}, stage 1", whole.interval, whole.inputs, temperature, ("duty",), ("temperature",), units
        ),
        Sampled(
            f"{whole.name}, stage 2", whole.interval, temperature, position, ("temperature",), ("position",), units
        ),
    )


def sealed_bench(seed: int) -> tuple[ReferenceBench, float]:
    """Return another random bench, and the factor by which it needs more power.

    Ambient of 18 to 30 °C, a fan (film coefficient times 1.5 to 3), a wire share of 0.5 to 0.7 in the view of the
    thermometer with a drift of up to 0.05 in 10 minutes, 1 to 2 kg, relay correlation of 0.6 to 0.95, and cold ends.
    """
    rng = np.random.default_rng(seed)
    bench = ReferenceBench()
    fan, ambient = float(rng.uniform(1.5, 3.0)), float(rng.uniform(291.15, 303.15))
    eye = bench.thermometer.with_values(
        {"factor": float(rng.uniform(0.5, 0.7)), "drift": float(rng.uniform(-0.05, 0.05)) / 600.0}
    )
    random_bench = ReferenceBench(
        fan=fan,
        ambient=ambient,
        load=float(rng.uniform(1.0, 2.0)),
        cells=4.0,
        correlation=float(rng.uniform(0.6, 0.95)),
        thermometer=eye,
    )
    return random_bench, fan
