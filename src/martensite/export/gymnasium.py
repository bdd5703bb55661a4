"""A bench as an environment of Gymnasium. The learner controls the drives without a controller.

    environment = SmaEnv(bench, Task(output="position", low=0.0, high=4e-3, duration=20.0))

`martensite.export.episodes` and `martensite.export.learning_task` define observations, rewards and references.

Gymnasium comes with `pip install 'martensite[gymnasium]'`.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from martensite.base.errors import require_known
from martensite.base.lazy import import_extra
from martensite.control.loop.bench import Bench
from martensite.export.episodes import BOUND, Episodes
from martensite.export.frames import Frames
from martensite.export.gymnasium_names import register_environments
from martensite.export.learning_task import LearningTask
from martensite.export.packaged_tasks import find_bench

RENDER_MODES = ("rgb_array",)
HERE = find_spec("gymnasium") is not None
BASE: Any = import_module("gymnasium").Env if HERE else object


def import_gymnasium() -> Any:
    """Return the package."""
    return import_extra("gymnasium", "gymnasium", "Gymnasium")


class SharedEpisodes:
    """Episodes of a bench and their pictures, the base of single and vector environments."""

    metadata: dict[str, Any] = {"render_modes": list(RENDER_MODES)}  # noqa: RUF012 - as Gymnasium has it

    def _prepare(
        self,
        bench: Bench | str,
        task: LearningTask | Mapping[str, Any] | None,
        count: int,
        native: bool | None,
        render_mode: str | None,
    ) -> tuple[Any, Any]:
        """Create the episodes, and return the action and observation spaces of one environment."""
        box: Any = import_gymnasium().spaces.Box
        if render_mode is not None:
            require_known("render mode", render_mode, RENDER_MODES)
        bench, task = find_bench(bench, task)
        self._episodes = Episodes(bench, task, count, native)
        self._frames: Frames | None = None
        self.render_mode = render_mode
        self.metadata = type(self).metadata | {"render_fps": max(1, round(1.0 / bench.period))}
        actions, observations = self._episodes.sizes
        return box(-1.0, 1.0, (actions,), np.float32), box(-BOUND, BOUND, (observations,), np.float32)

    def _watch(self) -> None:
        """Record the last period for pictures, if there is a render mode."""
        if self.render_mode is not None:
            self._frames = self._frames or Frames(self._episodes)
            self._frames.watch()


class SmaEnv(SharedEpisodes, BASE):
    """A bench as a `gymnasium.Env`.

    An action holds one value from -1 to 1 per free drive. An observation holds readings, the reference and its preview,
    from -2 to 2. Both are float32.
    """

    def __init__(
        self,
        bench: Bench | str,
        task: LearningTask | Mapping[str, Any] | None = None,
        *,
        native: bool | None = None,
        render_mode: str | None = None,
    ) -> None:
        """Create an environment before its first reset.

        Args:
            bench: with at least one free drive; or the name of a packaged task.
            task: learning task; for a packaged task optional changes of its fields.
            native: whether to run in C; by default if there is a compiler.
            render_mode: `rgb_array` for pictures.

        Raises:
            InputError: Gymnasium is not installed, or a name or range does not fit.
            ParameterError: a spread is not allowed.
        """
        self.action_space, self.observation_space = self._prepare(bench, task, 1, native, render_mode)

    def reset(self, *, seed: int | None = None, options: Mapping[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: of reference, plant and noise of this and all later episodes.
            options: `reference`, a waveform, and `values`, parameters of the bench by path; they replace random ones.

        Raises:
            InputError: the option is unknown.
        """
        super().reset(seed=seed)
        observations, extras = self._episodes.begin(np.ones(1, bool), [self.np_random], options)
        self._watch()
        return observations[0], {name: float(row[0]) for name, row in extras.items()}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Run one period; return observation, reward, terminated, truncated, and true values [SI]."""
        outcome = self._episodes.step(np.asarray(action, float)[None])
        self._watch()
        extras = {name: float(row[0]) for name, row in outcome.extras.items()}
        return (
            outcome.observations[0],
            float(outcome.rewards[0]),
            bool(outcome.terminated[0]),
            bool(outcome.truncated[0]),
            extras,
        )

    def render(self) -> Any:
        """Return the picture, 8 bits, shape (height, width, 3); None without a `render_mode` or before `reset`."""
        return None if self._frames is None else self._frames.draw(0)


if HERE:
    register_environments()
