"""Read MuJoCo models, and compute the tensions of a static pose.

A model is the path of an MJCF file, MJCF text, or an `MjSpec`. Elements are added to a copy of it, as actuators after
its own ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from martensite.base.errors import InputError, SolveError, require_known
from martensite.base.lazy import import_extra

OLDEST = 4
"""Oldest major version of MuJoCo that the C supports."""
TRIAL_TENSION = 1.0
"""Change of tension for measured compliances [N]."""
REGULARISATION = 1e-9
"""Fraction of the largest compliance that is added to all, so that redundant tendons share a load."""
HOLDING_TOLERANCE = 1e-3
"""Allowed remaining motion, as a fraction of the motion without tensions."""


def load_mujoco() -> Any:
    """Return the module `mujoco`."""
    mujoco = import_extra("mujoco", "mujoco", "MuJoCo")
    if int(mujoco.__version__.split(".")[0]) < OLDEST:
        raise InputError(
            f"MuJoCo {mujoco.__version__} is installed, but version {OLDEST} or newer is needed: "
            "run `pip install --upgrade mujoco`."
        )
    return mujoco


def read_spec(model: Any) -> Any:
    """Return a new `MjSpec` of a model.

    Args:
        model: the path of an MJCF file, MJCF text, or an `MjSpec`, which is copied.
    """
    kind = load_mujoco().MjSpec
    if isinstance(model, kind):
        return model.copy()
    text = isinstance(model, str) and model.lstrip().startswith("<")
    if not text and not Path(model).is_file():
        raise InputError(f"There is no MJCF file `{model}`.")
    try:
        return kind.from_string(model) if text else kind.from_file(str(model))
    except ValueError as error:
        raise InputError(f"MuJoCo cannot read the model: {error}") from error


def compile_spec(spec: Any) -> Any:
    """Compile an `MjSpec`."""
    mujoco = load_mujoco()
    try:
        model = spec.compile()
    except ValueError as error:
        raise InputError(f"MuJoCo cannot make the model: {error}") from error
    if model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_ACTUATION):
        raise InputError("The model disables actuation: its tendons cannot be driven.")
    return model


def begin_data(model: Any, keyframe: str | None) -> Any:
    """Return new data, optionally in a keyframe."""
    mujoco = load_mujoco()
    data = mujoco.MjData(model)
    if keyframe is not None:
        names = [model.key(k).name for k in range(model.nkey)]
        require_known("keyframe of the model is", keyframe, names)
        mujoco.mj_resetDataKeyframe(model, data, names.index(keyframe))
    return data


def find_tendons(model: Any, tendons: Sequence[str]) -> list[int]:
    """Return the indices of tendons by name."""
    names = [model.tendon(k).name for k in range(model.ntendon)]
    for name in tendons:
        require_known("tendon of the model is", name, names)
    return [names.index(name) for name in tendons]


def measure_tendons(model: Any, data: Any) -> Any:
    """Return the lengths of all tendons [m] at the present coordinates.

    After `mj_step` the lengths in the data are those at the start of the step.
    """
    mujoco = load_mujoco()
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_tendon(model, data)
    return data.ten_length.copy()


def find_joints(model: Any, joints: Sequence[str] | None) -> dict[str, int]:
    """Return the index of the position of each hinge or slide among the coordinates.

    Args:
        model: an `MjModel`.
        joints: names of hinges and slides; by default all that have names.
    """
    kinds = load_mujoco().mjtJoint
    simple = (int(kinds.mjJNT_HINGE), int(kinds.mjJNT_SLIDE))
    places = {
        model.joint(k).name: int(model.jnt_qposadr[k])
        for k in range(model.njnt)
        if model.jnt_type[k] in simple and model.joint(k).name
    }
    for name in joints or ():
        require_known("hinge or slide", name, places)
    return places if joints is None else {name: places[name] for name in joints}


def add_tendon_actuator(spec: Any, tendon: str, **settings: Any) -> Any:
    """Add an actuator without limits and dynamics to a tendon, regardless of the model's defaults, and return it."""
    mujoco = load_mujoco()
    actuator = spec.add_actuator(trntype=mujoco.mjtTrn.mjTRN_TENDON, target=tendon, **settings)
    actuator.gaintype, actuator.dyntype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtDyn.mjDYN_NONE
    actuator.gear[:] = (1.0, *[0.0] * 5)
    actuator.ctrllimited = actuator.forcelimited = actuator.actlimited = 0
    return actuator


def holding_tensions(model: Any, tendons: Sequence[str], *, keyframe: str | None = None) -> dict[str, float]:
    """Return the tensions that keep a model at rest.

    MuJoCo makes one step from rest, without tensions and with trial tensions. If several tendons can share a load, the
    solution with the smallest sum of squares is returned: add the preload to it.

    Args:
        model: the path of an MJCF file, MJCF text, or an `MjSpec`.
        tendons: names of the tendons that may pull.
        keyframe: name of the keyframe with the pose; by default the pose of the model.

    Returns:
        Tension [N] by tendon, the `start_force` of an element.

    Raises:
        InputError: the model cannot be read, or has no such tendon or keyframe.
        SolveError: no tensions of these tendons keep it at rest.
    """
    trial = _HoldingTrial(model, tendons, keyframe)
    free = trial.find_motion(np.zeros(len(tendons)))
    rows = [(free - trial.find_motion(TRIAL_TENSION * unit)) / TRIAL_TENSION for unit in np.eye(len(tendons))]
    tensions = _solve_nonnegative(np.array(rows), free)
    left = trial.find_motion(tensions)
    if not np.abs(left).max() <= HOLDING_TOLERANCE * np.abs(free).max():
        raise SolveError(
            f"No tensions of {', '.join(tendons)} hold the model in this pose; give `start_force` "
            "by hand, or another pose."
        )
    return dict(zip(tendons, tensions.tolist(), strict=True))


class _HoldingTrial:
    """One step of a model from rest under given tensions."""

    def __init__(self, model: Any, tendons: Sequence[str], keyframe: str | None) -> None:
        spec = read_spec(model)
        self._tendons = find_tendons(compile_spec(spec), tendons)
        for tendon in tendons:
            actuator = add_tendon_actuator(spec, tendon)
            actuator.gainprm[0], actuator.biastype = -1.0, load_mujoco().mjtBias.mjBIAS_NONE
        self._model = compile_spec(spec)
        self._start = begin_data(self._model, keyframe)
        self._start.qvel[:] = 0.0
        self._lengths = measure_tendons(self._model, self._start)[self._tendons]

    def find_motion(self, tensions: Any) -> Any:
        """Return the lengthening of the tendons [m] in a step under tensions [N]."""
        mujoco = load_mujoco()
        data = mujoco.MjData(self._model)
        mujoco.mj_copyData(data, self._model, self._start)
        data.ctrl[-len(tensions) :] = tensions
        mujoco.mj_step(self._model, data)
        return measure_tendons(self._model, data)[self._tendons] - self._lengths


def _solve_nonnegative(compliances: Any, lengthening: Any) -> Any:
    """Return F ≥ 0 with S F = b where F > 0 and S F ≥ b elsewhere: the minimum of F·SF/2 - b·F."""
    from scipy.optimize import nnls

    symmetric = 0.5 * (compliances + compliances.T)
    weak = REGULARISATION * max(float(np.diag(symmetric).max()), np.finfo(float).tiny)
    lower = np.linalg.cholesky(symmetric + weak * np.eye(len(symmetric)))
    return nnls(lower.T, np.linalg.solve(lower, lengthening))[0]
