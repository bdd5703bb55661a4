"""At which tensions a MuJoCo model stays in the pose in which it is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from martensite.base.errors import SolveError
from martensite.export.balance import solve_nonnegative
from martensite.export.mujoco_bridge import begin_data, read_model
from martensite.export.mujoco_plant import TendonPlant

TRIED = 1.0
"""Difference of a tension by which slopes are measured [N]."""
WEAK = 1e-9
"""Share of the largest slope that is added to all, so that tendons may balance each other."""
HELD = 1e-3
"""Share of the motion without tensions that may be left."""


def holding_tensions(
    model: Any, tendons: Sequence[str], *, data: Any = None, keyframe: str | None = None
) -> dict[str, float]:
    """Tensions [N] that hold a model still at its tendons; the `start_force` of its elements.

    Of a step from rest MuJoCo is asked how far the tendons get, without tensions and with them.
    Where several tendons can share a load, the smallest tensions (in the sum of squares) are
    taken: add to them what should be preload.

    Args:
        model: an `MjModel`, or the path of an MJCF file, or MJCF text.
        tendons: those that may pull; they need actuators as for `MujocoBridge`.
        data: the `MjData` in the pose that is to be held; it is left as it is.
        keyframe: name of the keyframe with that pose, instead of `data`.

    Raises:
        InputError: the model cannot be driven so.
        SolveError: no tensions of these tendons hold it.
    """
    model = read_model(model)
    plant = TendonPlant(model, begin_data(model, keyframe) if data is None else data, tendons)
    plant.remember_state(still=True)
    none = [0.0] * len(tendons)
    here, ends = plant.lengths(), plant.after(none)
    slopes = np.array(plant.gives(none, ends, [TRIED] * len(tendons)))
    away = np.array(ends) - here
    weak = WEAK * np.eye(len(none)) * np.diag(slopes).max()
    tensions = solve_nonnegative(0.5 * (slopes + slopes.T) + weak, away, np.zeros(len(none)))
    left = np.array(plant.after(tensions.tolist())) - here
    if not np.abs(left).max() <= HELD * np.abs(away).max():
        raise SolveError(
            f"No tensions of {', '.join(tendons)} hold the model in this pose; give `start_force` "
            "by hand, or another pose."
        )
    return dict(zip(tendons, tensions.tolist(), strict=True))
