r"""Levels of waveforms as system parameters, with exact derivatives.

A waveform is affine in its levels q: its signal is

u(t) = u_0(t) + Σ_k q_k φ_k(t)

The extended system is driven by the fixed signals u_0 and φ_k, and its parameters include the levels. Levels can
therefore vary within a batch and have exact derivatives. Times of a waveform cannot be parameters, since they move
the edges at which steps end.

high          a level that the waveform declares
peak          the largest signal of the run, as a scale of the whole waveform
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from martensite.actuators.assembly import AbstractSystem, Feed
from martensite.actuators.assembly.base import DriveSignal
from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.base.errors import ParameterError, suggest_name
from martensite.base.parameters import REQUIRED, FieldDeclaration, Parametrised, part
from martensite.kernels.namespace import Namespace, Scalar
from martensite.physics.laws.coupling import StepReport
from martensite.signals.base import DRIVE, AbstractWaveform
from martensite.signals.moments import Moments, Segment, Tone, add_segments
from martensite.simulate.drive_waveforms import Waveforms, arrange_waveforms

PEAK = "peak"
LOOKED_AT = 2001
"""Times in addition to edges for the peak of a waveform and the affinity check."""
AFFINE = 1e-9
"""Largest relative deviation of a signal from its affine form."""


@dataclass(frozen=True)
class Level:
    """Level of the waveform of a drive."""

    drive: str
    name: str
    """`peak`, or the path of a declared level."""
    value: float
    """Value in the scenario, in the SI unit of the drive."""


class Levels(Parametrised):
    """Levels q0, q1, … in the unit of their drive."""

    def __init__(self, **levels: float) -> None:
        self.__dict__.update(levels)

    @property
    def declarations(self) -> dict[str, FieldDeclaration]:  # type: ignore[override]
        """Return one parameter per level."""
        return {name: FieldDeclaration("parameter", "level of a waveform", REQUIRED, DRIVE) for name in self.__dict__}


class Combined(AbstractWaveform):
    """Weighted sum of waveforms."""

    terms: tuple[tuple[float, AbstractWaveform], ...] = part("factors and waveforms")

    def value(self, time: float) -> float:
        """Return the signal at `time` [s]."""
        return math.fsum(factor * wave.value(time) for factor, wave in self.terms)

    def edges(self, duration: float) -> list[float]:
        """Return the edges of all terms."""
        return sorted({edge for _, wave in self.terms for edge in wave.edges(duration)})

    def segments(self, begin: float) -> Iterator[Segment]:
        """Return the summed segments of all terms."""
        return add_segments([(factor, wave.segments(begin)) for factor, wave in self.terms])

    def tones(self) -> tuple[Tone, ...]:
        """Return the tones of all terms."""
        return tuple(
            tone._replace(amplitude=factor * tone.amplitude) for factor, wave in self.terms for tone in wave.tones()
        )


def pair_name(first: int, second: int) -> str:
    """Return the name of the drive that is the sum of two signals."""
    return f"q{second} with {'the rest' if first < 0 else f'q{first}'}"


def hand_on(name: str) -> Callable[..., Any]:
    """Return a method that delegates to the driven system."""

    def answer(self: WaveformLevelSystem, *values: Any) -> Any:
        return getattr(self.system, name)(*values)

    return answer


class WaveformLevelSystem(AbstractSystem, init=False):
    """System with signals that are sums of fixed signals and levels."""

    system: AbstractSystem = part("what is driven")
    levels: Levels = part("levels of its waveforms", default=Levels())
    owners: tuple[str, ...] = part("the drive that each level belongs to", default=())

    def layout(self) -> tuple[int, ...]:
        """Return the drive of each level."""
        names = [drive.name for drive in self.system.drives()]
        return tuple(names.index(owner) for owner in self.owners)

    @property
    def mechanism(self) -> AbstractMechanism:  # type: ignore[override]
        """Return the mechanism of the system."""
        return self.system.mechanism

    sample_time = hand_on("sample_time")
    actuators = hand_on("actuators")
    label = hand_on("label")
    drive_at = hand_on("drive_at")
    signals = hand_on("signals")
    convergence_scales = hand_on("convergence_scales")
    description = hand_on("description")
    outputs = hand_on("outputs")
    profile = hand_on("profile")

    def drives(self) -> list[DriveSignal]:
        """Return the drives of the system, of the constant part, of each level, and of pairs."""
        own = self.system.drives()
        levels = zip(self.levels.declarations, self.layout(), strict=True)
        # Drive of every pair.
        pairs = zip([self.layout()[k] for _, k in self.pairs()], self.pairs(), strict=True)
        return [
            *own,
            *(own[place]._replace(name=name) for name, place in levels),
            *(own[place]._replace(name=pair_name(*pair)) for place, pair in pairs),
        ]

    def pairs(self) -> list[tuple[int, int]]:
        """Return the pairs of signals of a drive with relevant product: two levels, or -1 for u_0."""
        layout = self.layout()
        own = self.system.drives()
        pairs = [(-1, k) for k in range(len(layout))]
        pairs += [(j, k) for k in range(len(layout)) for j in range(k) if layout[j] == layout[k]]
        return [pair for pair in pairs if not own[layout[pair[1]]].at_end]

    def init(self, xp: Namespace, *drives: Scalar) -> Any:
        """Return the initial state under the summed signals."""
        return self.system.init(xp, *self._signals(drives))

    def step(self, xp: Namespace, state: Any, *drives: Scalar | Feed, dt: Scalar) -> tuple[Any, StepReport]:
        """Advance by `dt` [s]."""
        count = len(self.system.drives())
        fed = [self._sum_drives(xp, place, drives) for place in range(count)]
        return self.system.step(xp, state, *fed, dt=dt)

    def heat_contents(self, xp: Namespace, state: Any) -> list[Scalar | None]:
        """Return the heat contents of the system; levels have no heat."""
        contents = self.system.heat_contents(xp, state)
        return contents + [None] * (len(self.drives()) - len(contents))

    def observe(self, xp: Namespace, state: Any, *drives: Scalar) -> list[Scalar]:
        """Return all outputs."""
        return self.system.observe(xp, state, *self._signals(drives))

    def _signals(self, drives: Sequence[Scalar]) -> list[Scalar]:
        """Return u = u_0 + Σ q φ of every drive of the system."""
        places, numbers = self.layout(), list(self.levels.__dict__.values())
        count = len(self.system.drives())
        signals = list(drives[:count])
        for place, level, shape in zip(places, numbers, drives[count:], strict=False):
            signals[place] = signals[place] + level * shape
        return signals

    def _sum_drives(self, xp: Namespace, place: int, drives: Sequence[Any]) -> Scalar | Feed:
        """Return the input of a drive of the system, as the sum of its parts.

        ⟨u²⟩ = ⟨u_0²⟩ + Σ q_k² ⟨φ_k²⟩ + 2 Σ q_j q_k ⟨φ_j φ_k⟩, where ⟨φ_j φ_k⟩ follows from the
        mean square of φ_j + φ_k, and φ_0 = u_0 with q_0 = 1.
        """
        if not isinstance(drives[place], Feed):
            return self._signals(drives)[place]
        count, numbers = len(self.system.drives()), list(self.levels.__dict__.values())
        own = [k for k, owner in enumerate(self.layout()) if owner == place]
        parts = {-1: drives[place].moments} | {k: drives[count + k].moments for k in own}
        factors = {-1: 1.0} | {k: numbers[k] for k in own}
        mean = square = low = high = lapse = slope = second = 0.0
        for k, one in parts.items():
            q = factors[k]
            mean, square = mean + q * one.mean, square + q * q * one.square
            slope, second = slope + q * one.slope, second + q * q * one.square_slope
            ends = q * one.low, q * one.high
            low, high = low + xp.minimum(*ends), high + xp.maximum(*ends)
            lapse = xp.maximum(lapse, one.lapse)
        for (j, k), both in zip(self.pairs(), drives[count + len(numbers) :], strict=True):
            if k in parts:
                product = both.moments.square - parts[j].square - parts[k].square
                square = square + factors[j] * factors[k] * product
                product = both.moments.square_slope - parts[j].square_slope - parts[k].square_slope
                second = second + factors[j] * factors[k] * product
        return Feed(Moments(mean, square, low, high, lapse, slope, second), drives[place].owed)


@dataclass(frozen=True)
class WaveformLevels:
    """Waveforms of a system with selected levels as parameters."""

    system: AbstractSystem
    waveforms: Waveforms
    duration: float
    """Duration of a run [s]."""
    levels: tuple[Level, ...] = ()

    @cached_property
    def own(self) -> dict[str, AbstractWaveform]:
        """Return the waveform of every drive."""
        names = [drive.name for drive in self.system.drives()]
        return dict(zip(names, arrange_waveforms(self.system, self.waveforms), strict=True))

    def with_levels(self, levels: Sequence[Level]) -> WaveformLevels:
        """Return the waveforms with these levels as parameters; `ParameterError` if a signal is not affine."""
        waveforms = WaveformLevels(self.system, self.waveforms, self.duration, tuple(levels))
        for drive in waveforms.own:
            waveforms.require_affine(drive)
        return waveforms

    def available(self) -> list[Level]:
        """Return all possible levels: declared levels, and the peak of each waveform."""
        units = {drive.name: drive.unit for drive in self.system.drives()}
        levels: list[Level] = []
        for name, wave in self.own.items():
            levels += [
                Level(name, leaf.path, float(leaf.value)) for leaf in wave.leaves() if leaf.declared.unit == DRIVE
            ]
            peak = self._peak(wave)
            if units[name] != "K" and peak > 0.0:
                levels.append(Level(name, PEAK, peak))
        return levels

    def level(self, drive: str, name: str) -> Level:
        """Return a level of a drive by name; raise `ParameterError` if the name is unknown."""
        levels = {(level.drive, level.name): level for level in self.available()}
        if (drive, name) not in levels:
            names = [level for owner, level in levels if owner == drive]
            raise ParameterError(f"The waveform of `{drive}` has no level `{name}`. {suggest_name(name, names)}")
        return levels[drive, name]

    @cached_property
    def whole(self) -> AbstractSystem:
        """Return the compiled system: the original or the extended one."""
        if not self.levels:
            return self.system
        numbers = {f"q{k}": level.value for k, level in enumerate(self.levels)}
        owners = tuple(level.drive for level in self.levels)
        return WaveformLevelSystem(system=self.system, levels=Levels(**numbers), owners=owners)

    def path(self, path: str) -> str:
        """Return the path in `whole` of a parameter of the system."""
        return f"system.{path}" if self.levels else path

    def level_path(self, level: Level) -> str:
        """Return the path in `whole` of a level."""
        return f"levels.q{self.levels.index(level)}"

    def system_waveforms(self) -> dict[str, AbstractWaveform]:
        """Return the waveform of every drive of `whole`."""
        if not self.levels:
            return self.own
        rests = {drive: self._rest(drive) for drive in self.own}
        shapes = {f"q{k}": self._shape(level) for k, level in enumerate(self.levels)}
        waveforms: dict[str, AbstractWaveform] = {**rests, **shapes}
        whole = self.whole
        for j, k in whole.pairs() if isinstance(whole, WaveformLevelSystem) else ():
            first = rests[self.levels[k].drive] if j < 0 else shapes[f"q{j}"]
            waveforms[pair_name(j, k)] = Combined(terms=((1.0, first), (1.0, shapes[f"q{k}"])))
        return waveforms

    def at(self, drive: str, values: Mapping[str, float]) -> AbstractWaveform:
        """Return the waveform of a drive at other levels by name, unchecked."""
        wave = self.own[drive]
        if PEAK in values:
            peak = self._peak(wave)
            wave = Combined(terms=((values[PEAK] / peak, wave),))
        declared = {name: value for name, value in values.items() if name != PEAK}
        return wave.rebuilt(declared) if declared else wave

    def require_affine(self, drive: str) -> None:
        """Raise `ParameterError` unless the signal is affine in its levels."""
        mine = [level for level in self.levels if level.drive == drive]
        if not mine:
            return
        if len(mine) > 1 and any(level.name == PEAK for level in mine):
            raise ParameterError(
                f"The peak of the waveform of `{drive}` and another level of it cannot both be "
                "free: the peak scales them all."
            )
        moved = {level.name: level.value + 0.4 * (1.0 + k) * _choose_reach(level) for k, level in enumerate(mine)}
        there, rest = self.at(drive, moved), self._rest(drive)
        shapes = [(moved[level.name], self._shape(level)) for level in mine]
        for time in self._times(self.own[drive]):
            signal = there.value(time)
            affine_signal = rest.value(time) + math.fsum(q * shape.value(time) for q, shape in shapes)
            if abs(signal - affine_signal) > AFFINE * (1.0 + abs(signal)):
                raise ParameterError(
                    f"The signal of `{drive}` is not affine in its "
                    f"{', '.join(f'`{level.name}`' for level in mine)}, which cannot be free."
                )

    def _shape(self, level: Level) -> AbstractWaveform:
        """Return φ, the change of the signal per change of a level."""
        reach = _choose_reach(level)
        here, there = self.own[level.drive], self.at(level.drive, {level.name: level.value + reach})
        if level.name == PEAK:
            return Combined(terms=((1.0 / level.value, here),))
        return Combined(terms=((1.0 / reach, there), (-1.0 / reach, here)))

    def _rest(self, drive: str) -> AbstractWaveform:
        """Return u_0, the part of a drive that is independent of its levels."""
        mine = [level for level in self.levels if level.drive == drive]
        if not mine:
            return self.own[drive]
        if mine[0].name == PEAK:
            return Combined(terms=((0.0, self.own[drive]),))
        shapes = tuple((-level.value, self._shape(level)) for level in mine)
        return Combined(terms=((1.0, self.own[drive]), *shapes))

    def _times(self, wave: AbstractWaveform) -> list[float]:
        even = [self.duration * k / (LOOKED_AT - 1) for k in range(LOOKED_AT)]
        return sorted({*even, *wave.edges(self.duration)})

    def _peak(self, wave: AbstractWaveform) -> float:
        return max(abs(wave.value(time)) for time in self._times(wave))


def _choose_reach(level: Level) -> float:
    """Return the increment of a level for its derivative."""
    return abs(level.value) or 1.0
