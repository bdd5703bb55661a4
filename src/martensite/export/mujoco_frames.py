"""Draws poses of a MuJoCo model: the program that `martensite.export.mujoco_render` starts.

It is a process of its own because MuJoCo chooses its graphics when it is imported, from the
variable `MUJOCO_GL`, and because a graphics driver that fails may end the process.

    python -m martensite.export.mujoco_frames FOLDER

reads `model.mjb`, `poses.npy` (frames, coordinates) and `view.json` from the folder, and writes
`frames.npy` (frames, height, width, 3).
"""

from __future__ import annotations

import json
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np


def draw_poses(folder: Path) -> None:
    """Draw all poses in a folder."""
    mujoco: Any = import_module("mujoco")

    view = json.loads((folder / "view.json").read_text(encoding="utf-8"))
    model = mujoco.MjModel.from_binary_path(str(folder / "model.mjb"))
    width, height = view["size"]
    model.vis.global_.offwidth = max(model.vis.global_.offwidth, width)
    model.vis.global_.offheight = max(model.vis.global_.offheight, height)
    data, poses = mujoco.MjData(model), np.load(folder / "poses.npy")
    renderer = mujoco.Renderer(model, height, width)
    try:
        frames = [_draw_frame(renderer, mujoco, model, data, pose, view["camera"]) for pose in poses]
    finally:
        renderer.close()
    np.save(folder / "frames.npy", np.stack(frames))


def _draw_frame(renderer: Any, mujoco: Any, model: Any, data: Any, pose: Any, camera: str | None) -> np.ndarray:
    data.qpos[:] = pose
    mujoco.mj_forward(model, data)
    renderer.update_scene(data, camera=-1 if camera is None else camera)
    return renderer.render().copy()


if __name__ == "__main__":
    draw_poses(Path(sys.argv[1]))
