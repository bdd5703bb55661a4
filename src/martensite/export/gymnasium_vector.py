"""Vector environment of Gymnasium: all environments run as one batch in C.

Environment k with seed s runs like a `SmaEnv` with seed s + k. The autoreset mode of Gymnasium decides when a finished
episode restarts: in the next step, whose action is ignored (`NEXT_STEP`); in the same step, with the last observation
in `final_obs` (`SAME_STEP`); or by `options["reset_mask"]` (`DISABLED`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

import numpy as np

from martensite.base.errors import InputError, require_known
from martensite.control.loop.bench import Bench
from martensite.export.episodes import Outcome
from martensite.export.gymnasium import HERE, SharedEpisodes, import_gymnasium
from martensite.export.learning_task import LearningTask

VECTOR: Any = import_module("gymnasium.vector") if HERE else None
BASE: Any = VECTOR.VectorEnv if HERE else object
MODES: dict[str, Any] = {one.value: one for one in VECTOR.AutoresetMode} if HERE else {}


class SmaVectorEnv(SharedEpisodes, BASE):
    """A bench as a `gymnasium.vector.VectorEnv`."""

    def __init__(
        self,
        bench: Bench | str,
        task: LearningTask | Mapping[str, Any] | None = None,
        num_envs: int = 1,
        *,
        autoreset_mode: Any = "NextStep",
        native: bool | None = None,
        render_mode: str | None = None,
    ) -> None:
        """Create environments before their first reset.

        Args:
            bench: with at least one free drive; or the name of a packaged task.
            task: learning task; for a packaged task optional changes of its fields.
            num_envs: number of environments.
            autoreset_mode: one of `gymnasium.vector.AutoresetMode`.
            native: whether to run in C; by default if there is a compiler.
            render_mode: `rgb_array` for pictures.

        Raises:
            InputError: Gymnasium is not installed, or a name or range does not fit.
            ParameterError: a spread is not allowed.
        """
        import_gymnasium()
        self._mode = _find_mode(getattr(autoreset_mode, "value", autoreset_mode))
        single = self._prepare(bench, task, num_envs, native, render_mode)
        self.metadata |= {"autoreset_mode": self._mode}
        self.num_envs = num_envs
        self.single_action_space, self.single_observation_space = single
        batch: Any = VECTOR.utils.batch_space
        self.action_space, self.observation_space = (batch(one, num_envs) for one in single)
        self._random: list[Any] = [None] * num_envs
        self._over = np.zeros(num_envs, bool)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode in each environment.

        Args:
            seed: of the first environment, increased by 1 for each next; or one per environment.
            options: as for `SmaEnv`, and `reset_mask`, a mask of environments.

        Raises:
            InputError: the option is unknown, or the number of seeds is wrong.
        """
        given = dict(options or {})
        which = np.asarray(given.pop("reset_mask", np.ones(self.num_envs, bool)), bool)
        self._seed_environments(seed, which)
        observations, extras = self._episodes.begin(which, self._random, given)
        self._over &= ~which
        self._watch()
        return observations, _arrange_info(extras, which)

    def render(self) -> tuple[Any, ...] | None:
        """Return a picture of each environment, shape (height, width, 3)."""
        return None if self._frames is None else tuple(map(self._frames.draw, range(self.num_envs)))

    def _seed_environments(self, seed: int | Sequence[int | None] | None, which: Any) -> None:
        count, fresh = self.num_envs, import_gymnasium().utils.seeding.np_random
        seeds = [seed] * count if seed is None else seed
        seeds = [seeds + k for k in range(count)] if isinstance(seeds, int) else list(seeds)
        if len(seeds) != count:
            raise InputError(f"There are {count} environments, but {len(seeds)} seeds.")
        for k in np.flatnonzero(which):
            if seeds[k] is not None or self._random[k] is None:
                self._random[k] = fresh(seeds[k])[0]

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Run one period of all environments; return arrays, and the true values by name [SI]."""
        answer = self._step_all(actions)
        self._watch()
        return answer

    def _step_all(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        outcome, before = self._episodes.step(actions), self._over
        over = outcome.terminated | outcome.truncated
        if self._mode is MODES["NextStep"]:
            return self._next_step(outcome, before, over)
        self._over = over
        if self._mode is MODES["SameStep"] and over.any():
            return self._same_step(outcome, over)
        return *outcome[:4], _arrange_info(outcome.extras)

    def _next_step(self, outcome: Outcome, restarts: Any, over: Any) -> Any:
        """Return the results of a step, where episodes that ended before restart."""
        self._over = over & ~restarts
        if not restarts.any():
            return *outcome[:4], _arrange_info(outcome.extras)
        observations, extras = self._episodes.begin(restarts, self._random)
        observations[~restarts] = outcome.observations[~restarts]
        extras = {name: np.where(restarts, row, outcome.extras[name]) for name, row in extras.items()}
        rewards = np.where(restarts, 0.0, outcome.rewards)
        ended = outcome.terminated & ~restarts, outcome.truncated & ~restarts
        return observations, rewards, *ended, _arrange_info(extras)

    def _same_step(self, outcome: Outcome, over: Any) -> Any:
        """Return the results of a step, where episodes that end now restart at once."""
        observations, extras = self._episodes.begin(over, self._random)
        observations[~over] = outcome.observations[~over]
        infos: dict[str, Any] = {}
        for k in np.flatnonzero(over):
            last = {name: float(row[k]) for name, row in outcome.extras.items()}
            final = {"final_obs": outcome.observations[k], "final_info": last}
            infos = self._add_info(infos, final, int(k))
        extras = {name: np.where(over, row, outcome.extras[name]) for name, row in extras.items()}
        return observations, *outcome[1:4], infos | _arrange_info(extras)


def _find_mode(name: str) -> Any:
    require_known("autoreset mode", name, MODES)
    return MODES[name]


def _arrange_info(extras: Mapping[str, Any], which: Any = None) -> dict[str, Any]:
    """Return the additional information in Gymnasium's form: arrays and their masks."""
    arrays: dict[str, Any] = {}
    for name, row in extras.items():
        arrays |= {name: row, f"_{name}": np.ones(len(row), bool) if which is None else which}
    return arrays
