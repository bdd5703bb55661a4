"""Many environments of Gymnasium at once: all are lanes of one run in C.

Environment k under a seed s goes the way of a `SmaEnv` under the seed s + k. What happens when an
episode is over is said by the mode of Gymnasium: it begins anew in the next step, whose action is
left out (`NEXT_STEP`), in the same step, with the last observation in `final_obs` (`SAME_STEP`),
or when it is reset by `options["reset_mask"]` (`DISABLED`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

import numpy as np

from martensite.base.errors import InputError, suggest_name
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
            task: what shall be done on it; for a packaged task the fields that shall be others, if any.
            num_envs: how many.
            autoreset_mode: one of `gymnasium.vector.AutoresetMode`.
            native: whether to run in C; by default if there is a compiler.
            render_mode: `rgb_array`, if pictures are wanted.

        Raises:
            InputError: Gymnasium is not installed, or a name or range does not fit.
            ParameterError: a spread does not fit.
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
        """Begin an episode in every environment.

        Args:
            seed: of the first environment, the next number for the next; or one for each.
            options: as for `SmaEnv`, and `reset_mask`, which environments are meant.

        Raises:
            InputError: the option is unknown, or the number of seeds is wrong.
        """
        given = dict(options or {})
        which = np.asarray(given.pop("reset_mask", np.ones(self.num_envs, bool)), bool)
        self._seed_environments(seed, which)
        found, shown = self._episodes.begin(which, self._random, given)
        self._over &= ~which
        self._watch()
        return found, _arrange_info(shown, which)

    def render(self) -> tuple[Any, ...] | None:
        """Return a picture of every environment, each of shape (height, width, 3)."""
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
        """Run one period of all environments and return arrays, and the true values by name [SI]."""
        answer = self._step_all(actions)
        self._watch()
        return answer

    def _step_all(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        found, before = self._episodes.step(actions), self._over
        over = found.terminated | found.truncated
        if self._mode is MODES["NextStep"]:
            return self._next_step(found, before, over)
        self._over = over
        if self._mode is MODES["SameStep"] and over.any():
            return self._same_step(found, over)
        return *found[:4], _arrange_info(found.shown)

    def _next_step(self, found: Outcome, begun: Any, over: Any) -> Any:
        """Return the results of a step; environments whose episode ended before have begun a new one."""
        self._over = over & ~begun
        if not begun.any():
            return *found[:4], _arrange_info(found.shown)
        seen, shown = self._episodes.begin(begun, self._random)
        seen[~begun] = found.observations[~begun]
        shown = {name: np.where(begun, row, found.shown[name]) for name, row in shown.items()}
        rewards = np.where(begun, 0.0, found.rewards)
        ended = found.terminated & ~begun, found.truncated & ~begun
        return seen, rewards, *ended, _arrange_info(shown)

    def _same_step(self, found: Outcome, over: Any) -> Any:
        """Return the results of a step; environments whose episode ends now begin a new one at once."""
        seen, shown = self._episodes.begin(over, self._random)
        seen[~over] = found.observations[~over]
        infos: dict[str, Any] = {}
        for k in np.flatnonzero(over):
            last = {name: float(row[k]) for name, row in found.shown.items()}
            final = {"final_obs": found.observations[k], "final_info": last}
            infos = self._add_info(infos, final, int(k))
        shown = {name: np.where(over, row, found.shown[name]) for name, row in shown.items()}
        return seen, *found[1:4], infos | _arrange_info(shown)


def _find_mode(name: str) -> Any:
    if name not in MODES:
        raise InputError(f"There is no autoreset mode `{name}`. {suggest_name(name, MODES)}")
    return MODES[name]


def _arrange_info(shown: Mapping[str, Any], which: Any = None) -> dict[str, Any]:
    """Return the additional information as Gymnasium expects it: an array and its mask."""
    found: dict[str, Any] = {}
    for name, row in shown.items():
        found |= {name: row, f"_{name}": np.ones(len(row), bool) if which is None else which}
    return found
