"""Random scenarios in which every measure and alarm is compared with the same run at a tight tolerance.

A trial draws a structure, its numbers, drives, tolerance and measures from its seed. The reference has the same system
and drives at `TIGHT`; a measure is read from the track of the reference and from `SAMPLES` stored samples. The true
error is the larger of both differences. The difference from samples is lessened by what their distance explains.
"""

from __future__ import annotations

import math
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from builders import Swings

from laboratory.structures import STRUCTURES, Structure
from martensite.actuators.assembly import AbstractSystem
from martensite.base.errors import BudgetError, InputError, SolveError
from martensite.base.status import Status
from martensite.signals.base import AbstractWaveform
from martensite.signals.moments import Tone
from martensite.signals.pwm import PulseWidthModulation
from martensite.signals.sine import Sine
from martensite.signals.step import Step
from martensite.signals.table import Table
from martensite.signals.triangle import Triangle
from martensite.simulate.alarms import Alarm, farthest_changes, find_excursion
from martensite.simulate.api import simulate
from martensite.simulate.measures.base import measure_samples, parse_measure
from martensite.simulate.restarts import HOME, find_restart
from martensite.simulate.result import Result

TIGHT = 1e-7
"""Tolerance of the reference; structures with `closeness` have one that is a fraction of the tolerance of the trial."""
SAMPLES = 100_001
"""Stored samples of the reference in one trial of `FULL`; a tenth of them in the others."""
FULL = 20
TOLERANCES = (1e-3, 1e-4, 1e-5)
BUDGET = 20.0
"""CPU time [s] of a trial."""
COMPARED, LEFT, FAILED, OVERLONG = "compared", "left the envelope", "failed", "over the CPU limit"
OUTCOMES = (COMPARED, LEFT, FAILED, OVERLONG)
MEASURED = 12
"""Measures drawn in a trial."""
KINDS = ("step", "pulse", "pwm", "fast pwm", "sine", "fast sine", "tones", "triangle", "table")
NAMES = ("max", "min", "stroke", "change", "mean", "integral", "rms", "energy", "final", "at")
EVENTS = ("rise-time", "fall-time", "reach-time", "peak-time")
READ = ("temperature", "hottest", "stress", "strain", "force", "current", "voltage", "power", "resistance")
"""Outputs of elements that are measured, besides all coordinates of the mechanism."""
VARIED = (
    "diameter",
    "length",
    "heat_capacity",
    "latent_heat",
    "h",
    "h0",
    "stiffness",
    "preload",
    "mass",
    "E_A",
    "damping",
)
"""Numbers that a trial changes, by the ends of their paths."""
EXTREMES, NEAR = ("max", "min", "stroke", "change"), 100
"""Measures of extreme values, and samples next to which a peak may be."""
JUMP = 0.01
"""Change of a column between two samples that is a jump, as a fraction of its range."""
RESTARTED = 0.2
"""Fraction of the trials that go on from a restart."""
ALARMS = {"temperature": "hottest", "stress": "stress", "strain": "strain"}


@dataclass(frozen=True)
class Compared:
    """A measure, or a number of an alarm, beside its reference."""

    seed: int
    structure: str
    kind: str
    """Kinds of the drives."""
    tolerance: float
    words: str
    found: float
    true: float
    """Error."""
    claimed: float | None
    """Bound that was reported; None for none."""

    @property
    def ratio(self) -> float:
        """True error over the claimed one; 0 where nothing is claimed."""
        if self.true == 0.0 or self.claimed is None:
            return 0.0
        return self.true / self.claimed if self.claimed > 0.0 else math.inf

    @property
    def name(self) -> str:
        """Measure, or number of an alarm."""
        return self.words.partition("(")[0]


@dataclass(frozen=True)
class Tried:
    """A trial and its outcome."""

    seed: int
    structure: str
    kind: str
    tolerance: float
    outcome: str
    """One of `OUTCOMES`."""
    reason: str = ""
    """Message of a trial without comparisons."""
    rows: tuple[Compared, ...] = ()


@dataclass(frozen=True)
class Trial:
    """What a seed draws."""

    seed: int
    name: str
    system: AbstractSystem
    drives: dict[str, AbstractWaveform]
    kinds: str
    duration: float
    tolerance: float
    restart: float | None
    """Time [s] from which the measured run goes on."""
    measures: list[str]

    @property
    def tight(self) -> float:
        """Tolerance of the reference."""
        return max(TIGHT, STRUCTURES[self.name].closeness * self.tolerance)

    @property
    def samples(self) -> int:
        """Stored samples of the reference."""
        return SAMPLES if self.seed % FULL == 0 else SAMPLES // 10 + 1

    def run(self, tolerance: float, samples: int, system: AbstractSystem | None = None) -> Result:
        """Run it, the second part alone if it goes on from a restart."""
        one, begin = system or self.system, HOME
        if self.restart is not None:
            first = simulate(
                one, self.drives, self.duration, tolerance=tolerance, runtime="c", samples=11, restart_at=[self.restart]
            )
            begin = find_restart(first.restarts, self.restart)
        return simulate(one, self.drives, self.duration, tolerance=tolerance, runtime="c", samples=samples, start=begin)


def make_trial(seed: int, name: str = "") -> Trial:
    """Draw a trial, of the structure that the seed names if none is given."""
    rng = np.random.default_rng([41, seed])
    name = name or list(STRUCTURES)[seed % len(STRUCTURES)]
    structure = STRUCTURES[name]
    system = vary_numbers(rng, structure.system)
    duration = structure.seconds * 10.0 ** rng.uniform(-0.2, 0.5)
    made = {drive: make_drive(rng, structure, ends, duration) for drive, ends in structure.levels.items()}
    kinds = ", ".join(dict.fromkeys(kind for _, kind in made.values()))
    if kinds == "pulse":
        duration *= 10.0 ** rng.uniform(0.0, 1.5)
    restart = duration * rng.uniform(0.1, 0.6) if rng.random() < RESTARTED else None
    measures = draw_measures(rng, system, restart or 0.0, duration)
    drives = {drive: wave for drive, (wave, _) in made.items()}
    tolerance = float(rng.choice(TOLERANCES))
    return Trial(seed, name, system, drives, kinds, duration, tolerance, restart, measures)


def vary_numbers(rng: Any, system: AbstractSystem) -> AbstractSystem:
    """Change some numbers of a system by a few percent; as it is where that is not allowed."""
    changed = {
        leaf.path: leaf.value * float(rng.uniform(0.85, 1.15))
        for leaf in system.leaves()
        if leaf.path.rpartition(".")[2] in VARIED and leaf.value
    }
    try:
        return system.with_values(changed)
    except InputError:
        return system


def make_drive(
    rng: Any, structure: Structure, ends: tuple[float, float], duration: float
) -> tuple[AbstractWaveform, str]:
    """Draw the waveform of a drive, and its kind."""
    kind = str(rng.choice(structure.kinds or KINDS))
    low, high = ends
    high = low + (high - low) * rng.uniform(0.6, 1.1)
    if kind == "step":
        return Step(
            low=low, high=high, at=duration * rng.uniform(0.0, 0.2), until=duration * rng.uniform(0.4, 1.1)
        ), kind
    if kind == "pulse":
        begin = duration * rng.uniform(0.1, 0.3)
        return Step(low=low, high=high, at=begin, until=begin + duration * 10.0 ** rng.uniform(-2.5, -0.7)), kind
    if kind in ("pwm", "fast pwm"):
        frequency = (rng.uniform(2.0, 12.0) if kind == "pwm" else rng.uniform(50.0, 200.0)) / duration
        duty = rng.uniform(0.1, 0.9)
        return PulseWidthModulation(low=low, high=high, frequency=frequency, duty=duty), kind
    if kind in ("sine", "fast sine"):
        frequency = (rng.uniform(0.5, 4.0) if kind == "sine" else rng.uniform(10.0, 60.0)) / duration
        return Sine(low=low, high=high * (1.3 if low == 0.0 else 1.0), frequency=frequency), kind
    if kind == "tones":
        rates = 2.0 * math.pi * 10.0 ** rng.uniform(-0.3, 1.3, 3) / duration
        swings = tuple(Tone(0.17 * (high - low), float(rate), float(rng.uniform(0.0, 6.0))) for rate in rates)
        return Swings(level=0.5 * (low + high), swings=swings), kind
    if kind == "triangle":
        return Triangle(low=low, high=high, frequency=rng.uniform(0.5, 4.0) / duration), kind
    times = np.sort(rng.uniform(0.0, duration, 6)) + np.arange(6) * 1e-3 * duration
    values = low + (high - low) * rng.random(8)
    values[0] = low
    return Table(times=(0.0, *times.tolist(), 1.1 * duration), values=tuple(values.tolist())), kind


def draw_measures(rng: Any, system: AbstractSystem, begin: float, duration: float) -> list[str]:
    """Draw measures of outputs that users read."""
    names = system.outputs()
    of_elements = [name for name in names if name.rpartition(".")[2] in READ]
    read = [*of_elements, *(name for name in system.mechanism.outputs() if name in names)]
    found = set[str]()
    for word in rng.choice([*NAMES, *EVENTS], MEASURED):
        name = str(rng.choice(read))
        if word == "energy":
            name = str(rng.choice([one for one in of_elements if one.endswith("power")] or read))
        if word == "at":
            found.add(f"at({name}, time={begin + (duration - begin) * rng.random():.9g} s)")
        else:
            found.add(f"{word}({name})")
    return sorted(found)


# ---------------------------------------------------------------- one trial


def try_trial(seed: int, structure: str = "") -> Tried:
    """Make a trial within `BUDGET`."""
    trial = make_trial(seed, structure)

    def close(outcome: str, reason: str = "", rows: Sequence[Compared] = ()) -> Tried:
        return Tried(seed, trial.name, trial.kinds, trial.tolerance, outcome, reason, tuple(rows))

    try:
        with limit_cpu(BUDGET):
            return close(COMPARED, rows=_compare(trial))
    except BudgetError as error:
        return close(OVERLONG, str(error))
    except SolveError as error:
        left = str(error).startswith(Status.OUT_OF_ENVELOPE.name)
        return close(LEFT if left else FAILED, str(error))


@contextmanager
def limit_cpu(seconds: float) -> Iterator[None]:
    """Raise `BudgetError` if the block takes more than `seconds` of CPU time."""

    def stop(*_: object) -> None:
        raise BudgetError(f"The trial took more than {seconds:g} s of CPU time.")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def _compare(trial: Trial) -> list[Compared]:
    """Compare a trial with its reference; raise `SolveError` if a run does not reach its end."""
    system = trial.system
    found = require_end(trial.run(trial.tolerance, 11), "the run")
    if trial.seed % 2 and system.actuators():
        system = place_limits(trial, found)
        found = trial.run(trial.tolerance, 11, system)
    meant = require_end(trial.run(trial.tight, trial.samples, system), "the reference")
    return [*compare_measures(trial, found, meant), *compare_alarms(trial, found, meant)]


def require_end(found: Result, name: str) -> Result:
    """Return a run that reached its end; raise `SolveError` with its status otherwise."""
    if found.status.failed:
        raise SolveError(f"{found.status.name} in {name}: {(found.warnings or [''])[0]}")
    return found


def compare_measures(trial: Trial, found: Result, meant: Result) -> Iterator[Compared]:
    """Compare the measures of a trial with both references."""
    blurred = is_blurred(trial, meant)
    for words in trial.measures:
        value, exact = found.measure(words), meant.measure(words)
        true = 0.0 if value == exact else abs(value - exact)
        if not blurred:
            sampled, apart = read_samples(meant, words)
            if math.isfinite(sampled) and math.isfinite(apart):
                true = max(true, abs(value - sampled) - apart)
        yield trial_row(trial, words, value, true, found.bound(words))


def trial_row(trial: Trial, words: str, found: float, true: float, claimed: float | None) -> Compared:
    """A row of a trial."""
    return Compared(trial.seed, trial.name, trial.kinds, trial.tolerance, words, found, true, claimed)


def is_blurred(trial: Trial, meant: Result) -> bool:
    """Whether samples are too far apart for the drives, or step with them."""
    apart = trial.duration / trial.samples
    for wave in trial.drives.values():
        rates = [tone.rate / (2.0 * math.pi) for tone in wave.tones()]
        rates += [wave.frequency] if isinstance(wave, PulseWidthModulation) else []
        if any(rate * apart > 0.01 for rate in rates):
            return True
    return False


def read_samples(meant: Result, words: str) -> tuple[float, float]:
    """A measure of the stored samples, and how far it may be off for their distance.

    That is three times the change of the measure if every second or third sample is left out. A jump of a column may be
    anywhere between two samples.
    """
    one = parse_measure(words)
    times, columns = meant["time"], {name: meant[name][None] for name in one.columns(meant.system)}
    every = float(measure_samples(one, meant.system, times, columns)[0])
    apart = 0.0
    for stride, first in ((2, 0), (2, 1), (3, 1)):
        kept = np.arange(len(times)) % stride == first
        kept[0] = kept[-1] = True
        few = measure_samples(one, meant.system, times[kept], {n: c[:, kept] for n, c in columns.items()})
        apart = max(apart, 3.0 * abs(every - float(few[0])))
    for column in columns.values():  # a peak between two samples
        changes, top = np.abs(np.diff(column[0])), np.argsort(np.abs(column[0] - column[0].mean()))[-NEAR:]
        near = changes[np.clip(top[:, None] + [-1, 0], 0, len(changes) - 1)]
        apart += float(near[near <= JUMP * np.ptp(column)].max(initial=0.0)) if one.registered_name in EXTREMES else 0.0
    length, whole = times[2] - times[1], times[-1] - times[0]
    if one.averages:
        changes = np.abs(np.diff(np.concatenate(list(columns.values())), axis=1))
        jumps = length * float(changes[changes > JUMP * np.ptp(list(columns.values()))].sum())
        largest = float(np.abs(list(columns.values())).max())
        scale = {"mean": 1.0 / whole, "rms": largest / (whole * every) if every else 0.0}
        apart += jumps * scale.get(one.registered_name, 1.0)
    return every, apart + (2.0 * length if one.registered_name in EVENTS else 0.0)


# ---------------------------------------------------------------- alarms


def place_limits(trial: Trial, found: Result) -> AbstractSystem:
    """The system of a trial with limits within the ranges of its run."""
    rng = np.random.default_rng([42, trial.seed])
    limits: dict[str, float] = {}
    for leaf in trial.system.leaves():
        quantity = leaf.path.rpartition(".limits.")[2].removesuffix("_limit")
        if quantity not in ALARMS or ".limits." not in leaf.path:
            continue
        ends = [found.find_range(name) for name in found.outputs if name.rpartition(".")[2] == ALARMS[quantity]]
        low, high = min(end[0] for end in ends), max(end[1] for end in ends)
        start = 0.0 if quantity == "strain" else low
        limits[leaf.path] = start + (high - low) * float(rng.uniform(0.3, 0.9))
    possible = {path: value for path, value in limits.items() if value > 0.0}
    try:
        return trial.system.with_values(possible)
    except InputError:
        return trial.system


def compare_alarms(trial: Trial, found: Result, meant: Result) -> Iterator[Compared]:
    """Compare the alarms of a trial with those of the reference.

    Claimed: the bound of the extreme value; for times, what they change by if the limit is off by that bound, or by the
    bound of the value at the first time or at the end of that duration. An alarm that only one of the runs has must be
    within the bound of its limit.
    """
    own, other = ({(one.kind, one.port): one for one in run.alarms if one.kind in ALARMS} for run in (found, meant))
    for kind, port in dict.fromkeys([*own, *other]):
        name = found.system.label(port, ALARMS[kind])
        off = found.bound(f"stroke({name})" if kind == "strain" else f"max({name})")
        assert off is not None
        pair = own.get((kind, port)), other.get((kind, port))
        if pair[0] is None or pair[1] is None:
            excess = (pair[0] or pair[1]).excess  # type: ignore[union-attr]
            yield trial_row(trial, f"alarm missed({name})", 0.0, excess, off)
            continue
        yield from compare_alarm(trial, name, (pair[0], pair[1]), (off, bound_crossings(found, name, pair[0])), meant)


def bound_crossings(found: Result, name: str, alarm: Alarm) -> float:
    """Return the largest bound of a value at the times at which an alarm begins and ends."""
    last = found.times[-1]
    times = (min(alarm.first + lasting, last) for lasting in (0.0, alarm.duration))
    return max(found.bound(f"at({name}, time={float(time)!r} s)") or 0.0 for time in times)


def compare_alarm(
    trial: Trial, name: str, pair: tuple[Alarm, Alarm], bounds: tuple[float, float], meant: Result
) -> Iterator[Compared]:
    """Compare worst value, first time and duration of an alarm."""
    (mine, right), off = pair, max(bounds)
    yield trial_row(trial, f"alarm worst({name})", mine.worst, abs(mine.worst - right.worst), bounds[0])
    times = meant["time"]
    margins = (farthest_changes(meant[name]) if mine.kind == "strain" else meant[name]) - right.limit
    shifted = [find_excursion(times, margins + sign * off) for sign in (-1.0, 0.0, 1.0)]
    hair = 2.0 * trial.duration / trial.samples
    if any(one is None for one in shifted):
        yield trial_row(trial, f"alarm first({name})", mine.first, abs(mine.first - right.first), None)
        yield trial_row(trial, f"alarm duration({name})", mine.duration, abs(mine.duration - right.duration), None)
        return
    low, here, high = shifted
    for word, value, exact in (("first", mine.first, right.first), ("duration", mine.duration, right.duration)):
        spread = max(abs(getattr(one, word) - getattr(here, word)) for one in (low, high))
        yield trial_row(trial, f"alarm {word}({name})", value, abs(value - exact), spread + hair)
