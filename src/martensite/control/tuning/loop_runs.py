"""Runs of a bench for many sets of numbers: outputs of batches, and exact derivatives.

A bench is traced whole, so gains and numbers of the plant are parameters of one program: in C
batches go side by side, and derivatives with respect to any of them are marched beside the values
(`martensite.simulate.native_slopes`). Without a compiler every run is made on plain floats, and
there are no derivatives.

Derivatives are those between switchings: where another gain makes a limit or an anti-windup act a
sample earlier, the run itself jumps a little.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from martensite.base.errors import ParameterError, suggest_name
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import MEASURED, name_loop_columns
from martensite.control.loop.run import noise_waveforms, reference_waveforms
from martensite.control.observers.base import ESTIMATED
from martensite.search.batch_runner import BatchRunner
from martensite.signals.base import AbstractWaveform
from martensite.signals.sampling.sampled import Numbers
from martensite.simulate.drive_waveforms import grid_of


class Seen(NamedTuple):
    """Outputs of runs that the goal uses; with many runs, their axis is before the axis of samples."""

    output: Numbers
    """Output that follows the reference, without noise if it is an output of the plant."""
    reference: Numbers
    signal: Numbers
    """Signal of the controller, within its limits."""
    power: Numbers
    """Electrical power of all elements [W]."""
    hottest: Numbers
    """Highest temperature of any element [K]."""

    def one(self, k: int) -> Seen:
        """Return the outputs of one run of many."""
        return Seen(*(column[k] for column in self))


class LoopRuns(BatchRunner):
    """A bench, ready to be run with any numbers."""

    def __init__(
        self,
        bench: Bench,
        duration: float,
        *,
        drive: str | None = None,
        seed: int | None = 0,
        waveforms: Mapping[str, AbstractWaveform] | None = None,
        native: bool | None = None,
    ) -> None:
        """Prepare runs of one loop of a bench.

        Args:
            bench: with controllers.
            duration: length of every run [s].
            drive: whose controller is looked at; needed if there are several.
            seed: of noise and jitter, the same in every run; None for runs without.
            waveforms: of drives of the plant that no controller has.
            native: whether to run in C; by default if there is a compiler.

        Raises:
            ParameterError: the controller does not exist.
        """
        self.bench, self.drive = bench, find_loop(bench, drive)
        played = {**(waveforms or {}), **reference_waveforms(bench)}
        played |= noise_waveforms(bench, duration, seed)
        samples = int(duration / bench.period + 1e-6) + 1
        grid = grid_of(bench, played, duration, samples, bench.period)
        self.times = np.array(grid.times)
        self.output = find_judged_output(bench, self.drive)
        self._groups = self._name_columns()
        self._names = list(dict.fromkeys(name for group in self._groups for name in group))
        super().__init__(bench, grid, self._names, native=native)

    def run(self, table: Numbers) -> Seen:
        """Runs of a table of numbers, shape (runs, samples); NaN where a run fails."""
        return self._sort_columns(self.run_many(table))

    def slopes(self, values: Numbers, moving: Sequence[str]) -> tuple[Seen, Seen] | None:
        """Run one loop; return the run and its derivatives with respect to parameters, None if it fails.

        Derivatives have shape (samples, parameters).
        """
        seeds = np.zeros((len(values), len(moving)))
        for k, path in enumerate(moving):
            seeds[self.place(path), k] = 1.0
        found = self.run_slopes(values, seeds)
        return found and (self._sort_columns(found[0]), self._sort_columns(found[1], axis=1))

    def _name_columns(self) -> Seen:
        """Return the names of what is judged; several where they are put together."""
        plant = self.bench.plant
        reference, wanted, _ = name_loop_columns(self.bench, self.drive)
        ports = list(plant.actuators())
        names: list[Any] = [
            (self.output,),
            (reference,),
            (wanted,),
            tuple(plant.label(port, "power") for port in ports),
            tuple(plant.label(port, "hottest") for port in ports),
        ]
        return Seen(*names)

    def _sort_columns(self, rows: Numbers, axis: int = -1) -> Seen:
        """Return the columns by what they are, power added up and the hottest element chosen."""
        where: Any = self._groups
        taken = [rows.take([self._names.index(n) for n in group], axis) for group in where]
        first: list[Any] = [one.take(0, axis) for one in taken[:3]]
        hottest = taken[4].max(axis) if taken[4].size else np.zeros_like(first[0])
        return Seen(first[0], first[1], first[2], taken[3].sum(axis), hottest)


def find_loop(bench: Bench, drive: str | None) -> str:
    """Return the drive of the controller to be tuned.

    Raises:
        ParameterError: the controller does not exist, or several exist and the name is missing.
    """
    names = list(bench.controllers.members())
    if drive is None and len(names) == 1:
        return names[0]
    if drive not in names:
        said = "Name one of the loops of this bench" if drive is None else f"No loop `{drive}`"
        raise ParameterError(f"{said}. {suggest_name(drive or '', names)}")
    return drive


def find_judged_output(bench: Bench, drive: str) -> str:
    """Return the output by which a loop is judged: the truth where there is one, else the reading."""
    name = bench.controllers.members()[drive].measured
    known = bench.plant.outputs()
    mounted = bench.sensors.members().get(name)
    if mounted is not None:
        seen = mounted.sees()[0]
        same = seen in known and mounted.sensor.unit in (None, known[seen].unit)
        return seen if same else MEASURED + name
    bare = name.removeprefix(ESTIMATED)
    return bare if bare in known else name
