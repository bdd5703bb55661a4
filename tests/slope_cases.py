"""Runs whose derivatives are known: exact ones in C, and differences of the same run in C.

Steps are solved to rounding: a run that is not has other derivatives than its solution. Differences
are taken at several widths, and count only where two widths agree: at a kink, and below the noise,
they are no derivative.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from builders import chamber, example_system, examples, hanging_wire, label

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.mechanisms.testing_machine import TensileTestingMachine
from martensite.physics.electrical.sources import VoltageSource
from martensite.signals.base import AbstractWaveform
from martensite.signals.step import Step
from martensite.signals.triangle import Triangle
from martensite.simulate.compiled import CompiledMarch, compile_march
from martensite.simulate.drive_waveforms import arrange_waveforms
from martensite.simulate.grid import TimeGrid, grid_at
from martensite.simulate.native import march_lanes
from martensite.simulate.native_slopes import OutputSlopes, march_slopes

MISMATCH = 1e-8
STEPS = {"ribbon": 0.005}
"""[s]; a ribbon makes a fixed number of sweeps over its wires, enough for short steps."""
WIDTHS = (1e-5, 1e-4, 1e-6)
"""Of differences; the others are tried where the first is rough."""
ROUGH = 2e-6
"""Disagreement of a width and its half, from which on a difference is none."""
GROUPS = 4
"""Directions in which differences are taken; every parameter moves in one of them."""
KELVINS = 10.0
"""Size of a temperature parameter [K]: the width of a strip, not the distance from 0 K."""
INSIDE = {"initial_fraction": 0.7, "initial_oriented": 0.4, "H_min": 0.04}
"""At the ends of its range a number has a derivative on one side only."""
ORIENTED = "initial_oriented"
"""Parameter that laws without twins fix at 1."""
WHOLE = ("heated", "passes")
"""Whole numbers."""
LEVELS = {"V": 4.0, "A": 0.9, "W": 3.2, "1": 1.0, "N": 5.0, "Pa": 100e6, "m": 1e-3, "m/s": 2.0}


@dataclass(frozen=True)
class Case:
    """A system and what drives it."""

    name: str
    system: AbstractSystem
    waves: dict[str, AbstractWaveform]
    duration: float = 3.0
    step: float = 0.02
    samples: int = 31

    @cached_property
    def compiled(self) -> CompiledMarch:
        return compile_march(self.system)

    @cached_property
    def grid(self) -> TimeGrid:
        waves = arrange_waveforms(self.system, self.waves)
        times = np.linspace(0.0, self.duration, self.samples).tolist()
        return grid_at(waves, times, self.step, [d.at_end for d in self.system.drives()])

    @cached_property
    def outputs(self) -> range:
        return range(len(self.compiled.outputs))

    @cached_property
    def values(self) -> np.ndarray:
        return np.array(self.compiled.values(self.system))

    @cached_property
    def sizes(self) -> np.ndarray:
        """(parameters,): by how much each of them moves; 0 for what cannot."""
        units = {leaf.path: leaf.declared.unit for leaf in self.system.leaves()}
        kelvins = np.array([units[path] == "K" for path in self.compiled.paths])
        whole = np.array([path.endswith(WHOLE) for path in self.compiled.paths])
        bare = np.array([path.endswith(ORIENTED) for path in self.compiled.paths]) & (self.values == 1.0)
        sizes = np.where(kelvins, KELVINS, self.values)
        return np.where(np.isfinite(sizes) & ~whole & ~bare, sizes, 0.0)

    def run(self, values: np.ndarray) -> np.ndarray:
        """Outputs (samples, outputs) without derivatives."""
        rows, worst = march_lanes(self.compiled, values.tolist(), self.grid, 1, self.outputs)
        assert worst[0, 0] <= MISMATCH, "a step is not solved to rounding"
        return rows[:, :, 0]

    def slopes(self, seeds: np.ndarray) -> OutputSlopes:
        """Outputs with exact derivatives; always in as many directions as there are parameters
        that move, so that one library is compiled."""
        count = seeds.shape[1]
        wide = np.pad(seeds, ((0, 0), (0, max(0, np.count_nonzero(self.sizes) - count))))
        found = march_slopes(self.compiled, self.values.tolist(), wide, self.grid, self.outputs)
        return found._replace(slopes=found.slopes[:, :, :count])

    @cached_property
    def directions(self) -> np.ndarray:
        """(parameters, GROUPS): parameters by turns, each as far as has about the same effect."""
        moving = np.flatnonzero(self.sizes)
        single = np.zeros((len(self.sizes), len(moving)))
        single[moving, range(len(moving))] = self.sizes[moving]
        found = self.slopes(single)
        shares = np.abs(found.slopes).max(axis=0) / spans(found.rows)[:, None]
        effects = np.clip(shares.max(axis=0), 0.1, 1e3)
        signs = np.random.default_rng(0).choice([-1.0, 1.0], len(moving))
        seeds = np.zeros((len(self.sizes), GROUPS))
        seeds[moving, np.arange(len(moving)) % GROUPS] = self.sizes[moving] * signs / effects
        return seeds

    def differences(self, seed: np.ndarray, largest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives in one direction, of fourth order, and where they are good."""
        best = rough = np.full((self.samples, len(self.outputs)), np.inf)
        for width in WIDTHS:
            far, back, near, short = (self.run(self.values + s * width * seed) for s in (1.0, -1.0, 0.5, -0.5))
            wide, narrow = (far - back) / (2.0 * width), (near - short) / width
            found, apart = (4.0 * narrow - wide) / 3.0, np.abs(narrow - wide) / largest
            best, rough = np.where(apart < rough, found, best), np.minimum(apart, rough)
            if (rough < ROUGH).all():
                break
        return best, rough < ROUGH

    def apart(self, seeds: np.ndarray | None = None) -> tuple[float, float]:
        """Largest error of exact derivatives, as a share of the largest of their output, where
        differences are good; and in which share of all places they are."""
        seeds = self.directions if seeds is None else seeds
        found = self.slopes(seeds)
        assert np.isfinite(found.slopes).all()
        errors, goods = [], []
        for k, seed in enumerate(self.directions.T):
            slopes = found.slopes[:, :, k]
            largest = np.maximum(np.abs(slopes).max(axis=0), 1e-4 * spans(found.rows))
            meant, good = self.differences(seed, largest)
            errors.append(np.where(good, np.abs(slopes - meant) / largest, 0.0))
            goods.append(good)
        return float(np.max(errors)), float(np.mean(goods))


def spans(rows: np.ndarray) -> np.ndarray:
    """(outputs,): ranges of outputs; a share of their size for what hardly moves."""
    return np.maximum(np.ptp(rows, axis=0), 1e-6 * np.abs(rows).max(axis=0) + 1e-300)


def inside(system: AbstractSystem) -> AbstractSystem:
    """A twin whose phases at the start and strains are inside their ranges, where its law allows it."""
    for ending, value in INSIDE.items():
        paths = [leaf.path for leaf in system.leaves() if leaf.path.endswith(ending)]
        bare = ending == ORIENTED and not all(getattr(part, "has_twins", True) for part in system.tree())
        system = system if bare else system.with_values(dict.fromkeys(paths, value))
    return system


def under_weight(law: Any) -> Case:
    """A wire of a law under a weight, heated by a pulse of voltage, and cooling."""
    system = hanging_wire(mass=1.7, source=VoltageSource(), law=law)
    wave = Step(low=0.0, high=4.5, at=0.1, until=1.4)
    return Case(f"weight-{label(law)}", inside(system), {"drive": wave}, 4.0)


def in_machine(law: Any) -> Case:
    """A wire in a testing machine, under a stress and a temperature that both change."""
    machine = TensileTestingMachine(control="stress", section=1.14e-7)
    system = chamber(law).with_parts(mechanism=machine)
    waves: dict[str, AbstractWaveform] = {
        "drive": Triangle(low=275.0, high=410.0, frequency=0.3),
        "command": Triangle(low=50e6, high=180e6, frequency=0.35),
    }
    return Case(f"machine-{label(law)}", inside(system), waves, 4.0, samples=61)


def exchanged(thing: Any) -> Case:
    """Problem A with one part exchanged, every other drive switched on for a while."""
    system, waves = example_system(thing), {}
    drives = system.drives()
    for k, drive in enumerate(drives):
        at, until, share = 0.1 + 0.05 * k, 1.5, 1.0 - 0.06 * k
        share = -share if getattr(thing, "conducts", "both") == "negative" else share
        if drive.unit == "K":
            waves[drive.name] = Step(low=295.0, high=390.0, at=at, until=until)
        elif k % 2 == 0 or len(drives) < 4:
            waves[drive.name] = Step(low=0.0, high=share * LEVELS[drive.unit], at=at, until=until)
    return Case(label(thing), inside(system), waves, step=STEPS.get(thing.registered_name, 0.02))


HEAVY = ("axial-wire", "ribbon", "hand", "parallel-platform", "mas-polycrystal")
"""Parts of which a case takes many seconds."""
SIMPLE = (
    *("current", "power", "voltage", "linear-amplifier", "temperature", "mosfet", "power-pwm"),
    *("constant", "polynomial", "morgan", "lefevre-ede", "churchill-bernstein", "radiation"),
    *("liang-rogers", "elahinia", "bundle", "chain", "lever", "dead-weight", "testing-machine", "torsion-wire"),
)
"""Parts that others of their kind cover."""
PULLED = ("brinson",)
"""Laws that are always tried in a testing machine too."""


def cases() -> Iterator[tuple[str, Callable[[], Case], bool]]:
    """All laws twice, all other registered parts of a system: names, how to make them, whether to try them always."""
    known: set[str] = set()
    for make, kind, word in (
        (under_weight, "law", "weight-"),
        (exchanged, "element", ""),
        (exchanged, "mechanism", ""),
        (exchanged, "drive", ""),
        (exchanged, "cooling", ""),
    ):
        for thing in examples(kind):
            name = thing.registered_name
            usual = name not in known and name not in HEAVY and name not in SIMPLE
            yield f"{word}{label(thing)}", partial(make, thing), usual
            if kind == "law" and name not in known:
                yield f"machine-{label(thing)}", partial(in_machine, thing), usual and name in PULLED
            known.add(name)
