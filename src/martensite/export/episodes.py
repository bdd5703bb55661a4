"""Episodes on a bench, many side by side: what environments for learners are made of.

Every environment is a lane of one `Lanes`. What an episode needs is drawn when it begins from the
random numbers of that environment alone: its reference, its plant, the noise of its sensors. So
an environment goes the same way alone as beside others.

Actions go from -1 to 1 between the lowest and highest signal of a drive. Observations are readings, the references
now and their previews, scaled so that their ranges become -1 to 1, and cut at ±2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from martensite.actuators.assembly.base import DriveSignal
from martensite.base.errors import InputError, suggest_name
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
"""Bound of observations."""
SHOWN = ("reference", "output", "power", "hottest")
"""Additional information of an environment, in SI; several outputs as `reference.NAME` and `output.NAME`."""
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
    shown: dict[str, Numbers]
    """By the names of `SHOWN`, each of shape (environments,)."""


class Episodes:
    """Environments side by side."""

    def __init__(self, bench: Bench, task: LearningTask, count: int = 1, native: bool | None = None) -> None:
        """Create environments before their first episode.

        Args:
            bench: with at least one free drive.
            task: what shall be done on it.
            count: how many.
            native: whether to run in C; by default if there is a compiler.

        Raises:
            InputError: a name does not fit, a range is missing, or the count is below 1.
            ParameterError: a spread does not fit.
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
        """Find the places of drives and outputs in the rows of lanes."""
        bench, task, plant = self.bench, self.task, self.bench.plant
        drives, seen = [one.name for one in self._drives], self._lanes.names.index
        self._acting = [drives.index(name) for name in self.signals]
        self._noisy = [k for k, name in enumerate(drives) if name.startswith((NOISE, JITTER))]
        self._followed = [drives.index(name) for name in reference_waveforms(bench)]
        for name in task.outputs:
            if name not in plant.outputs():
                raise InputError(f"There is no output `{name}`. {suggest_name(name, plant.outputs())}")
        self._output = [seen(name) for name in task.outputs]
        self._labels = [""] if isinstance(task.output, str) else [f".{name}" for name in task.outputs]
        self._read = [seen(name) for name in self.observed]
        ports = list(plant.actuators())
        self._power, self._hottest, self._stress = (
            [seen(plant.label(port, name)) for port in ports] for name in ("power", "hottest", "stress")
        )
        limits = [one.element.limits for one in plant.actuators().values()]
        hot, high = task.temperature_limit, task.stress_limit
        self.temperature_limits = [one.temperature_limit if hot is None else hot for one in limits]
        """Temperature limit of the element at each port [K]."""
        self._most_heat = np.array(self.temperature_limits)[:, None]
        self._most_stress = np.array([one.stress_limit if high is None else high for one in limits])[:, None]

    def _set_tables(self) -> None:
        """Room for what is drawn, and what is played to the controllers of the bench."""
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
        """Return the numbers in an action and in an observation."""
        return len(self.signals), len(self._ranges)

    # ---------------------------------------------------------------- an episode

    def begin(
        self, which: Any, random: Sequence[np.random.Generator], options: Mapping[str, Any] | None = None
    ) -> tuple[Any, dict[str, Numbers]]:
        """Begin episodes in some environments; the others keep their state.

        Args:
            which: in which, shape (environments,).
            random: one generator per environment.
            options: `reference`, a waveform to follow or one by name of the output, and `values`, parameters of the
                bench by path, in place of what would be drawn.

        Returns:
            Observations of all environments, and what is shown of them.

        Raises:
            InputError: an option or a parameter is unknown.
        """
        given = dict(options or {})
        for name in given:
            if name not in OPTIONS:
                raise InputError(f"There is no option `{name}`. {suggest_name(name, OPTIONS)}")
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
        """Draw an episode of one environment; true if its plant is another."""
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
        """Let one environment follow waveforms where they are given."""
        outputs = self.task.outputs
        waves = given if isinstance(given, Mapping) else dict.fromkeys(outputs, given)
        for name, wave in waves.items():
            if name not in outputs:
                raise InputError(f"No output `{name}` follows a reference. {suggest_name(name, outputs)}")
            self._reference[:, outputs.index(name), k] = [wave.value(float(t)) for t in self._times]

    def step(self, actions: Any) -> Outcome:
        """Return one period of all environments.

        Args:
            actions: from -1 to 1, shape (environments, actions).

        Raises:
            InputError: an action is not a number.
        """
        given = np.asarray(actions, float)
        if np.isnan(given).any():
            raise InputError(f"An action must hold numbers from -1 to 1, but holds NaN: {given.tolist()}.")
        share = 0.5 * (np.clip(given, -1.0, 1.0).T + 1.0)
        signals = self._signals_at(self._low + share * self._span, 1)
        rows = self.rows = self._lanes.advance(signals[None], self.bench.period)[0]
        self._at = np.minimum(self._at + 1, self.length)
        shown = self._list_extras(rows)
        solved = np.isfinite(rows).all(axis=0) & (self._lanes.worst[0] <= SOLVED)
        hot = (rows[self._hottest] > self._most_heat).any(axis=0)
        strained = (np.abs(rows[self._stress]) > self._most_stress).any(axis=0)
        over = hot | strained | ~solved
        apart = np.abs(self._wanted() - rows[self._output]) / (self.task.high - self.task.low)
        error = np.minimum(apart, 1.0).mean(axis=0)
        cost = self.task.energy_weight * self.bench.period * shown["power"]
        lost = self._penalty + (self.length - self._at)
        rewards = np.where(solved, -error - cost, -1.0) - lost * over
        return Outcome(self._observation(rows), rewards, over, self._at >= self.length, shown)

    # ---------------------------------------------------------------- rows

    def list_outputs(self, k: int) -> dict[str, float]:
        """Return the outputs of one environment now [SI], by name."""
        return dict(zip(self._lanes.names, self.rows[:, k].tolist(), strict=True))

    def list_followed(self) -> tuple[Numbers, Numbers, Any]:
        """References and outputs now, shape (outputs, environments), and the periods since the episodes began."""
        return self._wanted(), self.rows[self._output], self._at

    def _signals_at(self, acting: Numbers, later: int) -> Numbers:
        """Return the signals of all drives: references and noise are those at the end of the period."""
        found = np.zeros((len(self._drives), self.count))
        at, lanes = np.minimum(self._at + later, self.length), np.arange(self.count)
        found[self._acting] = acting
        found[self._noisy] = self._noise[at, :, lanes].T
        found[self._followed] = self._played[at].T
        return found

    def _observation(self, rows: Numbers) -> Any:
        """Return the observations of the learner, shape (environments, observations)."""
        ahead = self._at[None, :] + np.array(self._ahead)[:, None]
        lanes = np.arange(self.count)
        wanted = [self._reference[at, :, lanes].T for at in ahead]
        found = scale_values(np.concatenate([rows[self._read], *wanted]), self._ranges)
        cut = np.clip(np.nan_to_num(found, nan=0.0), -BOUND, BOUND)
        return np.ascontiguousarray(cut.T, np.float32)

    def _wanted(self) -> Numbers:
        """Return the references now, shape (outputs, environments)."""
        return self._reference[self._at, :, np.arange(self.count)].T

    def _list_extras(self, rows: Numbers) -> dict[str, Numbers]:
        """Return the additional information, in the order of `SHOWN`."""
        found = {f"reference{name}": row for name, row in zip(self._labels, self._wanted(), strict=True)}
        found |= {f"output{name}": rows[k] for name, k in zip(self._labels, self._output, strict=True)}
        hottest = rows[self._hottest].max(axis=0, initial=0.0)
        return found | {"power": rows[self._power].sum(axis=0), "hottest": hottest}
