"""Pictures and films of a run of a MuJoCo model, with or without a screen.

Drawing needs OpenGL. Without a screen, `egl` and `osmesa` are tried, then `glfw` with a screen, unless the environment
variable `MUJOCO_GL` names one. A separate process (this module, as a program) draws, because a failing graphics
driver can end it.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from martensite.base.child_python import python_command, python_environment
from martensite.base.errors import DataError, MartensiteError, ParameterError, require_known
from martensite.base.files import replace_file
from martensite.export.mujoco_models import load_mujoco
from martensite.export.mujoco_result import MujocoResult

FILMS = (".mp4", ".gif")
INSTALL = (
    "No OpenGL that draws without a screen was found ({}). Install one, on Debian or Ubuntu with "
    "`apt install libegl1 libgl1-mesa-dri`, or run where a screen is."
)


def render_mujoco(
    model: Any,
    result: MujocoResult,
    path: str | Path,
    *,
    time: float | None = None,
    fps: float = 25.0,
    speed: float = 1.0,
    size: tuple[int, int] = (640, 480),
    camera: str | None = None,
) -> Path:
    """Draw a pose of a run as `.png`, or all of it as `.mp4` or `.gif`; return the written path.

    An MP4 needs the program ffmpeg (or the package `imageio-ffmpeg`); without it a GIF is written, with a warning.

    Args:
        model: the `mjModel` of the run.
        result: the result of `MujocoActuators.run`; its samples are the available poses.
        path: file to write; the suffix is the format.
        time: time of the pose [s]; by default the last one.
        fps: frames per second of a film.
        speed: playback speed of a film, 1 for real time.
        size: width and height in pixels.
        camera: name of a camera of the model; by default the free one.

    Raises:
        DataError: the suffix is unknown, or the file cannot be written.
        ParameterError: an argument is out of range.
        MartensiteError: drawing fails; the sentence says what to install.
    """
    path = Path(path)
    if path.suffix.lower() not in (".png", *FILMS):
        raise DataError(f"The picture `{path}` has no suffix that can be drawn: .png, .mp4, .gif.")
    if not (fps > 0.0 and speed > 0.0 and min(size) > 0):
        raise ParameterError("Arguments `fps`, `speed` and `size` must be above 0.")
    if camera is not None:
        require_known("camera of the model is", camera, [model.camera(i).name for i in range(model.ncam)])
    film = path.suffix.lower() in FILMS
    times = _film_times(result, fps, speed) if film else [result.times[-1] if time is None else time]
    frames = draw_poses(model, [_find_pose(result, t) for t in times], size, camera)
    return _write_film(frames, path, fps) if film else _write_png(frames[0], path)


def draw_poses(
    model: Any, poses: Sequence[Sequence[float]], size: tuple[int, int], camera: str | None = None
) -> np.ndarray:
    """Return pictures of poses, shape (frames, height, width, 3), by the first working OpenGL."""
    reasons: list[str] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        load_mujoco().mj_saveModel(model, str(folder / "model.mjb"), None)
        np.save(folder / "poses.npy", np.asarray(poses))
        view = json.dumps({"size": size, "camera": camera})
        (folder / "view.json").write_text(view, encoding="utf-8")
        for backend in _list_backends():
            failed = _draw_in_process(folder, backend)
            if failed is None:
                return np.load(folder / "frames.npy")
            reasons.append(f"{backend or 'default'}: {failed}")
    raise MartensiteError(INSTALL.format("; ".join(reasons)))


def _list_backends() -> tuple[str, ...]:
    chosen = os.environ.get("MUJOCO_GL", "")
    if chosen or not sys.platform.startswith("linux"):
        return (chosen,)
    return ("egl", "osmesa", "glfw") if os.environ.get("DISPLAY") else ("egl", "osmesa")


def _draw_in_process(folder: Path, backend: str) -> str | None:
    command = python_command("-m", "martensite.export.mujoco_render", str(folder))
    done = subprocess.run(
        command, env=python_environment(MUJOCO_GL=backend), capture_output=True, text=True, check=False
    )
    if done.returncode == 0:
        return None
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    return lines[-1].strip() if lines else f"ended with {done.returncode}"


def _find_pose(result: MujocoResult, time: float) -> list[float]:
    nearest = min(range(len(result.times)), key=lambda k: abs(result.times[k] - time))
    return result.poses[nearest]


def _film_times(result: MujocoResult, fps: float, speed: float) -> list[float]:
    first, last = result.times[0], result.times[-1]
    return [first + k * speed / fps for k in range(int((last - first) * fps / speed + 1e-9) + 1)]


def _write_png(frame: np.ndarray, path: Path) -> Path:
    from matplotlib.image import imsave

    with replace_file(path) as part:
        imsave(part, frame, format="png")
    return path


def _write_film(frames: np.ndarray, path: Path, fps: float) -> Path:
    if path.suffix.lower() == ".mp4":
        program = _find_ffmpeg()
        if program is not None:
            _write_mp4(program, frames, path, fps)
            return path
        path = path.with_suffix(".gif")
        warnings.warn(
            f"No ffmpeg was found, so `{path.name}` was written instead of an MP4; "
            "`pip install imageio-ffmpeg` brings one.",
            stacklevel=3,
        )
    _write_gif(frames, path, fps)
    return path


def _find_ffmpeg() -> str | None:
    program = shutil.which("ffmpeg")
    if program is None:
        try:
            from imageio_ffmpeg import get_ffmpeg_exe  # type: ignore[import-not-found]

            program = get_ffmpeg_exe()
        except (ImportError, RuntimeError):
            return None
    return program


def _write_mp4(program: str, frames: np.ndarray, path: Path, fps: float) -> None:
    """Write H.264 in an MP4. Its sides must be even: an odd last line or column is cropped."""
    _, height, width, _ = frames.shape
    with replace_file(path) as part:
        read = f"-f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {fps} -i -"
        write = "-vf crop=trunc(iw/2)*2:trunc(ih/2)*2 -pix_fmt yuv420p -f mp4"
        command = [program, *f"-y -loglevel error {read} {write}".split(), str(part)]
        done = subprocess.run(command, input=frames.tobytes(), capture_output=True, check=False)
        if done.returncode:
            lines = done.stderr.decode(errors="replace").strip().splitlines()
            raise DataError(f"ffmpeg could not write `{path}`: {lines[-1] if lines else ''}")


def _write_gif(frames: np.ndarray, path: Path, fps: float) -> None:
    from PIL import Image

    images = [Image.fromarray(frame) for frame in frames]
    with replace_file(path) as part:
        images[0].save(
            part, format="gif", save_all=True, append_images=images[1:], loop=0, duration=max(1000.0 / fps, 20.0)
        )


def draw_folder(folder: Path) -> None:
    """Draw all poses in a folder, in the process that `draw_poses` starts.

    It reads `model.mjb`, `poses.npy` (frames, coordinates) and `view.json`, and writes `frames.npy` (frames, height,
    width, 3).
    """
    mujoco = load_mujoco()
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
    draw_folder(Path(sys.argv[1]))
