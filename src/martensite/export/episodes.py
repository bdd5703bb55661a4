"""Episodes of parallel environments on a bench, the basis of environments for learners.

Each environment is one batch element of `Lanes`. Its random numbers alone decide reference, plant and noise of its
episodes, so an environment runs the same alone as in a batch.

Actions from -1 to 1 span the signal range of a drive. Observations are readings, and references now and at the preview
times, scaled to -1 to 1 over their ranges and clipped at ±2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from martensite.actuators.assembly.base import DriveSignal
from martensite.base.errors import InputError, require_known
from martensite.control.loop.bench import Bench
from martensite.control.loop.names import JITTER, NOISE
from martensite.control.loop.run import reference_waveforms
from martensite.export.learning_task import (
    LearningTask,
    Numbers,
    free_signals,
    observed_readings,
    scale_values,
    spreads_of,
)
from martensite.signals.base import AbstractWaveform
from martensite.simulate.lanes import Lanes
from martensite.simulate.march import SOLVED

BOUND = 2.0
"""Clipping bound of observations."""
SHOWN = ("reference", "output", "power", "hottest")
"""Additional information of an environment [SI]; several outputs are `reference.NAME` and `output.NAME`."""
OPTIONS = ("reference", "values")


class Outcome(NamedTuple):
    """Results of a period, arrays over the environments."""

    observations: Any
    """Shape (environments, observations)."""
    rewards: Numbers
    terminated: Any
    """True where a limit is exceeded or the step failed."""
    truncated: Any
    """True where the time is over."""
    extras: dict[str, Numbers]
    """By the names of `SHOWN`, each of shape (environments,)."""


class Episodes:
    """Parallel environments on one bench."""

    def __init__(self, bench: Bench, task: LearningTask, count: int = 1, native: bool | None = None) -> None:
        """Create environments before their first episode.

        Args:
            bench: with at least one free drive.
            task: learning task on the bench.
            count: number of environments.
            native: whether to run in C; by default if there is a compiler.
        """
        if count < 1:
            raise InputError(f"There must be an environment at least, but there are {count}.")
        self.bench, self.task, self.count = bench, task, count
        self.length = max(1, round(task.duration / bench.period))
        self._penalty = self.length if task.penalty is None else task.penalty
        self._ahead = [0, *(round(time / bench.period) for time in task.preview)]
        self._drives: list[DriveSignal] = bench.drives()
        self.signals = free_signals(bench, task)
        self.observed = observed_readings(bench, task)
        self._spreads = spreads_of(bench, task)
        self._values: dict[str, Numbers] = {one.path: np.full(count, one.middle) for one in self._spreads}
        self._lanes = Lanes(bench, count, self._values, native)
        self.rows: Numbers = np.zeros((len(self._lanes.names), count))
        """Outputs of the bench at the end of the last period, shape (outputs, environments)."""
        self._find_places()
        self._set_tables()

    def _find_places(self) -> None:
        """Find the indices of drives and outputs in the rows of `Lanes`."""
        bench, task = self.bench, self.task
        drives, find_row = [one.name for one in self._drives], self._lanes.names.index
        self._acting = [drives.index(name) for name in self.signals]
        self._noisy = [k for k, name in enumerate(drives) if name.startswith((NOISE, JITTER))]
        self._followed = [drives.index(name) for name in reference_waveforms(bench)]
        for name in task.outputs:
            require_known("output", name, bench.plant.outputs())
        self._output = [find_row(name) for name in task.outputs]
        self._labels = [""] if isinstance(task.output, str) else [f".{name}" for name in task.outputs]
        self._read = [find_row(name) for name in self.observed]
        self._find_limits()

    def _find_limits(self) -> None:
        task, plant, find_row = self.task, self.bench.plant, self._lanes.names.index
        ports = list(plant.actuators())
        self._power, self._hottest, self._stress = (
            [find_row(plant.label(port, name)) for port in ports] for name in ("power", "hottest", "stress")
        )
        limits = [one.element.limits for one in plant.actuators().values()]
        hot, high = task.temperature_limit, task.stress_limit
        self.temperature_limits = [one.temperature_limit if hot is None else hot for one in limits]
        """Temperature limit of the element at each port [K]."""
        self._most_heat = np.array(self.temperature_limits)[:, None]
        self._most_stress = np.array([one.stress_limit if high is None else high for one in limits])[:, None]

    def _set_tables(self) -> None:
        """Allocate references and noise, and tabulate the references of the bench."""
        self._at = np.zeros(self.count, int)
        self._times: Numbers = self.bench.period * np.arange(self.length + 1.0 + max(self._ahead))
        self._reference = np.zeros((len(self._times), len(self._output), self.count))
        self._noise = np.zeros((self.length + 2, len(self._noisy), self.count))
        played = list(reference_waveforms(self.bench).values())
        self._played = np.array(
            [[wave.value(float(t)) for wave in played] for t in self._times[: self.length + 1]]
        ).reshape(self.length + 1, len(played))
        low, high = np.array(list(self.signals.values())).T
        self._low, self._span = low[:, None], (high - low)[:, None]
        self._idle = np.clip(0.0, low, high)[:, None]
        followed = len(self._ahead) * len(self._output)
        self._ranges = [*self.observed.values(), *[(self.task.low, self.task.high)] * followed]

    @property
    def sizes(self) -> tuple[int, int]:
        """Return the sizes of an action and of an observation."""
        return len(self.signals), len(self._ranges)

    def begin(
        self, which: Any, random: Sequence[np.random.Generator], options: Mapping[str, Any] | None = None
    ) -> tuple[Any, dict[str, Numbers]]:
        """Begin episodes in some environments; the others keep their state.

        Args:
            which: mask of these environments, shape (environments,).
            random: one generator per environment.
            options: `reference`, a waveform or waveforms by output, and `values`, parameters of the bench by path; they
                replace random ones.

        Returns:
            Observations and additional information of all environments.
        """
        given = dict(options or {})
        for name in given:
            require_known("option", name, OPTIONS)
        chosen: list[int] = np.flatnonzero(which).tolist()
        changed = [self._draw(k, random[k], given) for k in chosen]
        state, worst = self._lanes.state, self._lanes.worst.copy()
        if any(changed):
            self._lanes.set_values(self._values)
        self._at[chosen] = 0
        signals = self._signals_at(self._idle, 0)
        self._lanes.reset(signals)
        others = np.flatnonzero(~np.asarray(which, bool))
        self._lanes.state[:, others] = state[:, others]
        self._lanes.worst[:, others] = worst[:, others]
        self.rows = self._lanes.observe(signals)
        return self._observation(self.rows), self._list_extras(self.rows)

    def _draw(self, k: int, rng: np.random.Generator, options: Mapping[str, Any]) -> bool:
        """Draw an episode of one environment; return True if its plant has changed."""
        before = [column[k] for column in self._values.values()]
        for spread in self._spreads:
            self._values[spread.path][k] = spread.draw(rng)
        self._reference[:, :, k] = np.transpose([self.task.reference(rng, self._times) for _ in self._output])
        self._noise[:, :, k] = rng.standard_normal(self._noise.shape[:2])
        for path, value in dict(options.get("values", {})).items():
            name = self.bench.resolve(path)
            nominal = self.bench.value_of(name)
            self._values.setdefault(name, np.full(self.count, nominal))[k] = value
        self._play_references(k, options.get("reference", {}))
        return before != [column[k] for column in self._values.values()]

    def _play_references(self, k: int, given: AbstractWaveform | Mapping[str, AbstractWaveform]) -> None:
        outputs = self.task.outputs
        waves = given if isinstance(given, Mapping) else dict.fromkeys(outputs, given)
        for name, wave in waves.items():
            require_known("output with a reference", name, outputs)
            self._reference[:, outputs.index(name), k] = [wave.value(float(t)) for t in self._times]

    def step(self, actions: Any) -> Outcome:
        """Return the results of one period of all environments.

        Args:
            actions: from -1 to 1, shape (environments, actions).
        """
        clean = np.asarray(actions, float)
        if np.isnan(clean).any():
            raise InputError(f"An action must hold numbers from -1 to 1, but holds NaN: {clean.tolist()}.")
        share = 0.5 * (np.clip(clean, -1.0, 1.0).T + 1.0)
        signals = self._signals_at(self._low + share * self._span, 1)
        rows = self.rows = self._lanes.advance(signals[None], self.bench.period)[0]
        self._at = np.minimum(self._at + 1, self.length)
        extras = self._list_extras(rows)
        solved = np.isfinite(rows).all(axis=0) & (self._lanes.worst[0] <= SOLVED)
        hot = (rows[self._hottest] > self._most_heat).any(axis=0)
        strained = (np.abs(rows[self._stress]) > self._most_stress).any(axis=0)
        over = hot | strained | ~solved
        deviation = np.abs(self._read_references() - rows[self._output]) / (self.task.high - self.task.low)
        error = np.minimum(deviation, 1.0).mean(axis=0)
        cost = self.task.energy_weight * self.bench.period * extras["power"]
        lost = self._penalty + (self.length - self._at)
        rewards = np.where(solved, -error - cost, -1.0) - lost * over
        return Outcome(self._observation(rows), rewards, over, self._at >= self.length, extras)

    def list_outputs(self, k: int) -> dict[str, float]:
        """Return the present outputs of one environment [SI], by name."""
        return dict(zip(self._lanes.names, self.rows[:, k].tolist(), strict=True))

    def list_followed(self) -> tuple[Numbers, Numbers, Any]:
        """Return present references and outputs (outputs, environments), and the periods since the start."""
        return self._read_references(), self.rows[self._output], self._at

    def _signals_at(self, acting: Numbers, later: int) -> Numbers:
        """Return the signals of all drives, with noise `later` periods ahead."""
        signals = np.zeros((len(self._drives), self.count))
        at, lanes = np.minimum(self._at + later, self.length), np.arange(self.count)
        signals[self._acting] = acting
        signals[self._noisy] = self._noise[at, :, lanes].T
        signals[self._followed] = self._played[at].T
        return signals

    def _observation(self, rows: Numbers) -> Any:
        ahead = self._at[None, :] + np.array(self._ahead)[:, None]
        lanes = np.arange(self.count)
        references = [self._reference[at, :, lanes].T for at in ahead]
        scaled = scale_values(np.concatenate([rows[self._read], *references]), self._ranges)
        cut = np.clip(np.nan_to_num(scaled, nan=0.0), -BOUND, BOUND)
        return np.ascontiguousarray(cut.T, np.float32)

    def _read_references(self) -> Numbers:
        """Return the present references, shape (outputs, environments)."""
        return self._reference[self._at, :, np.arange(self.count)].T

    def _list_extras(self, rows: Numbers) -> dict[str, Numbers]:
        extras = {f"reference{name}": row for name, row in zip(self._labels, self._read_references(), strict=True)}
        extras |= {f"output{name}": rows[k] for name, k in zip(self._labels, self._output, strict=True)}
        hottest = rows[self._hottest].max(axis=0, initial=0.0)
        return extras | {"power": rows[self._power].sum(axis=0), "hottest": hottest}
