"""A bench as an environment of Gymnasium: a learner has the drives that no controller has.

    environment = SmaEnv(bench, Task(output="position", low=0.0, high=4e-3, duration=20.0))

What is observed, rewarded and drawn is said in `martensite_export.episodes` and
`martensite_export.learning_task`. Importing this module registers `martensite/Bench-v0`, so that
`gymnasium.make("martensite_export.gymnasium:martensite/Bench-v0", bench=..., task=...)` works.

Gymnasium comes with `pip install 'martensite[gymnasium]'`.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from typing import Any, ClassVar

import numpy as np

from martensite.base.lazy import import_extra
from martensite.control.loop.bench import Bench
from martensite_export.episodes import BOUND, Episodes
from martensite_export.learning_task import LearningTask

NAME = "martensite/Bench-v0"
HERE = find_spec("gymnasium") is not None
BASE: Any = import_module("gymnasium").Env if HERE else object


def import_gymnasium() -> Any:
    """The package.

    Raises:
        InputError: Gymnasium is not installed.
    """
    return import_extra("gymnasium", "gymnasium", "Gymnasium")


def build_spaces(episodes: Episodes) -> tuple[Any, Any]:
    """Spaces of the actions and of the observations of one environment."""
    box: Any = import_gymnasium().spaces.Box
    actions, observations = episodes.sizes
    return box(-1.0, 1.0, (actions,), np.float32), box(-BOUND, BOUND, (observations,), np.float32)


class SmaEnv(BASE):
    """A bench as a `gymnasium.Env`.

    An action has one number per free drive, from -1 to 1; an observation the readings, the
    reference and its preview, from -2 to 2. Both are of 32 bits.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": []}

    def __init__(
        self, bench: Bench, task: LearningTask, *, native: bool | None = None, render_mode: None = None
    ) -> None:
        """An environment that has not been reset.

        Args:
            bench: with at least one drive that nobody has.
            task: what shall be done on it.
            native: whether to run in C; by default if there is a compiler.
            render_mode: nothing is rendered.

        Raises:
            InputError: Gymnasium is not installed, or a name or range does not fit.
            ParameterError: a spread does not fit.
        """
        import_gymnasium()
        self._episodes = Episodes(bench, task, 1, native)
        self.action_space, self.observation_space = build_spaces(self._episodes)
        self.render_mode = render_mode

    def reset(self, *, seed: int | None = None, options: Mapping[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: of reference, plant and noise of this and all later episodes.
            options: `reference`, a waveform, and `values`, parameters of the bench by path, in
                place of what would be drawn.

        Raises:
            InputError: there is no such option.
        """
        super().reset(seed=seed)
        found, shown = self._episodes.begin(np.ones(1, bool), [self.np_random], options)
        return found[0], {name: float(row[0]) for name, row in shown.items()}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """One period: observation, reward, terminated, truncated, and what is true [SI]."""
        found = self._episodes.step(np.asarray(action, float)[None])
        shown = {name: float(row[0]) for name, row in found.shown.items()}
        return (
            found.observations[0],
            float(found.rewards[0]),
            bool(found.terminated[0]),
            bool(found.truncated[0]),
            shown,
        )


if HERE:
    import_gymnasium().register(
        NAME, entry_point=f"{__name__}:SmaEnv", vector_entry_point=f"{__name__}_vector:SmaVectorEnv"
    )
