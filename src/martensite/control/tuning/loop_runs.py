"""Runs of a bench for many sets of parameters: outputs of batches, and exact derivatives.

A bench is traced whole, so gains and plant parameters are parameters of one program: in C batches run in vector
registers, and derivatives are integrated with the values (`martensite.simulate.native_slopes`). Without a compiler
every run is on floats, without derivatives.

Derivatives hold between switchings: where another gain makes a limit or an anti-windup act a sample earlier, the run
itself jumps a little.
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


class LoopOutputs(NamedTuple):
    """Outputs of runs for the goal, shape (samples,) or (runs, samples)."""

    output: Numbers
    """Output that follows the reference; without noise if it is an output of the plant."""
    reference: Numbers
    signal: Numbers
    """Limited signal of the controller."""
    power: Numbers
    """Electrical power of all elements [W]."""
    hottest: Numbers
    """Highest temperature of any element [K]."""

    def one(self, k: int) -> LoopOutputs:
        """Return the outputs of run k."""
        return LoopOutputs(*(column[k] for column in self))


class LoopRuns(BatchRunner):
    """A bench, ready to run with any parameters."""

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
            bench: bench with controllers.
            duration: duration of every run [s].
            drive: drive of the loop; required for several controllers.
            seed: seed of noise and jitter, equal in every run; None for runs without noise.
            waveforms: signals of drives without a controller.
            native: whether to run in C; default: if there is a compiler.

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

    def run(self, table: Numbers) -> LoopOutputs:
        """Run a table of parameters, shape (runs, parameters); NaN for a failed run."""
        return self._sort_columns(self.run_many(table))

    def slopes(self, values: Numbers, moving: Sequence[str]) -> tuple[LoopOutputs, LoopOutputs] | None:
        """Return a run and its derivatives, shape (samples, parameters); None if it fails."""
        seeds = np.zeros((len(values), len(moving)))
        for k, path in enumerate(moving):
            seeds[self.place(path), k] = 1.0
        run = self.run_slopes(values, seeds)
        return run and (self._sort_columns(run[0]), self._sort_columns(run[1], axis=1))

    def _name_columns(self) -> LoopOutputs:
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
        return LoopOutputs(*names)

    def _sort_columns(self, rows: Numbers, axis: int = -1) -> LoopOutputs:
        """Return the outputs, with the sum of the powers and the maximum of the temperatures."""
        where: Any = self._groups
        groups = [rows.take([self._names.index(n) for n in group], axis) for group in where]
        first: list[Any] = [one.take(0, axis) for one in groups[:3]]
        hottest = groups[4].max(axis) if groups[4].size else np.zeros_like(first[0])
        return LoopOutputs(first[0], first[1], first[2], groups[3].sum(axis), hottest)


def find_loop(bench: Bench, drive: str | None) -> str:
    """Return the drive of a controller.

    Raises:
        ParameterError: the controller does not exist, or several exist and the name is missing.
    """
    names = list(bench.controllers.members())
    if drive is None and len(names) == 1:
        return names[0]
    if drive not in names:
        problem = "Name one of the loops of this bench" if drive is None else f"No loop `{drive}`"
        raise ParameterError(f"{problem}. {suggest_name(drive or '', names)}")
    return drive


def find_judged_output(bench: Bench, drive: str) -> str:
    """Return the true output of a loop if there is one, else the reading."""
    name = bench.controllers.members()[drive].measured
    outputs = bench.plant.outputs()
    mounted = bench.sensors.members().get(name)
    if mounted is not None:
        output = mounted.sees()[0]
        same = output in outputs and mounted.sensor.unit in (None, outputs[output].unit)
        return output if same else MEASURED + name
    bare = name.removeprefix(ESTIMATED)
    return bare if bare in outputs else name
