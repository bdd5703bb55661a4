"""The MuJoCo side of the bridge: a model, its tendons, and what a step would do to their lengths.

Nothing of MuJoCo is rebuilt here. Where a tendon would end under a set of tensions is asked of
MuJoCo itself, by a whole step from the present state in a copy of it, so that whatever the model
holds is in the answer: its integrator, damping, contacts, joint limits, and other actuators.

A tendon needs an actuator that turns control into force, without bias and without limits:

    <actuator><general tendon="wire" gainprm="1" biastype="none"/></actuator>

MuJoCo counts the force of a tendon as positive when it lengthens it, so a tension F is the control -F/(gain · gear).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from martensite.base.errors import InputError, SolveError, UnknownNameError
from martensite.base.lazy import import_extra

LINE = '<actuator><general tendon="{}" gainprm="1" biastype="none"/></actuator>'


def load_mujoco() -> Any:
    """The module `mujoco`, or `InputError` where it is not installed."""
    return import_extra("mujoco", "mujoco", "MuJoCo")


class TendonPlant:
    """A model in motion, seen from some of its tendons."""

    def __init__(self, model: Any, data: Any, tendons: Sequence[str]) -> None:
        self.mujoco = load_mujoco()
        self.model, self.data = model, data
        if model.opt.disableflags & int(self.mujoco.mjtDisableBit.mjDSBL_ACTUATION):
            raise InputError("The model disables actuation: its tendons cannot be driven.")
        self.scratch = self.mujoco.MjData(model)
        self.tendons = [self._tendon(name) for name in tendons]
        wires = [self._actuator(i, name) for i, name in zip(self.tendons, tendons, strict=True)]
        self.controls = np.array([index for index, _ in wires])
        self.per_control = np.array([force for _, force in wires])
        self.what = self.mujoco.mjtState.mjSTATE_INTEGRATION
        self.held = np.zeros(self.mujoco.mj_stateSize(model, self.what))
        kinds = self.mujoco.mjtWarning
        bad = (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC)
        self.bad = [self.data.warning[int(kind)] for kind in bad]
        self.faults = self._faults()

    @property
    def dt(self) -> float:
        """Time step of the model [s]."""
        return float(self.model.opt.timestep)

    @property
    def time(self) -> float:
        """Of the model [s]."""
        return float(self.data.time)

    def lengths(self, data: Any = None) -> list[float]:
        """Lengths of the tendons [m] at the coordinates as they are now."""
        mujoco, model = self.mujoco, self.model
        data = self.data if data is None else data
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_tendon(model, data)
        return data.ten_length[self.tendons].tolist()

    def remember_state(self, *, still: bool = False) -> None:
        """Remember the present state, or its pose at rest, as where steps are tried from."""
        self.mujoco.mj_getState(self.model, self.data, self.held, self.what)
        if still:
            self.mujoco.mj_setState(self.model, self.scratch, self.held, self.what)
            self.scratch.qvel[:] = 0.0
            self.mujoco.mj_getState(self.model, self.scratch, self.held, self.what)

    def after(self, tensions: Sequence[float]) -> list[float]:
        """Lengths [m] after a step under tensions [N], tried in a copy."""
        self.mujoco.mj_setState(self.model, self.scratch, self.held, self.what)
        return self._step(self.scratch, tensions)

    def gives(self, tensions: Sequence[float], ends: Sequence[float], changes: Sequence[float]) -> list[list[float]]:
        """How much tendon i yields to tension j over a step [m/N], by differences.

        Args:
            tensions: where the slope is taken [N].
            ends: lengths after a step under them [m].
            changes: differences [N].
        """
        columns: list[list[float]] = []
        for j, change in enumerate(changes):
            tried = self.after([F + change * (i == j) for i, F in enumerate(tensions)])
            columns.append([(a - b) / change for a, b in zip(ends, tried, strict=True)])
            columns[j][j] = max(columns[j][j], 0.0)
        return [list(row) for row in zip(*columns, strict=True)]

    def advance(self, tensions: Sequence[float]) -> list[float]:
        """Make the step under tensions [N]; the lengths afterwards [m].

        Raises:
            SolveError: MuJoCo found the motion unstable.
        """
        time, lengths = self.time, self._step(self.data, tensions)
        if self._faults() != self.faults:
            raise SolveError(
                f"MuJoCo found the motion of the model unstable at t = {time:.6g} s. "
                "Try a smaller `timestep`, or more damping or armature of light joints."
            )
        return lengths

    def _step(self, data: Any, tensions: Sequence[float]) -> list[float]:
        data.ctrl[self.controls] = -np.asarray(tensions) / self.per_control
        self.mujoco.mj_step(self.model, data)
        return self.lengths(data)

    def _faults(self) -> int:
        return sum(warning.number for warning in self.bad)

    def _tendon(self, name: str) -> int:
        index = self.mujoco.mj_name2id(self.model, self.mujoco.mjtObj.mjOBJ_TENDON, name)
        if index < 0:
            known = [self.model.tendon(i).name for i in range(self.model.ntendon)]
            raise UnknownNameError("tendon of the model is", name, known)
        return index

    def _actuator(self, tendon: int, name: str) -> tuple[int, float]:
        """Number of the actuator of a tendon, and its force [N] per control."""
        model, kinds = self.model, self.mujoco
        plain = (
            (model.actuator_trntype == int(kinds.mjtTrn.mjTRN_TENDON))
            & (model.actuator_trnid[:, 0] == tendon)
            & (model.actuator_gaintype == int(kinds.mjtGain.mjGAIN_FIXED))
            & (model.actuator_biastype == int(kinds.mjtBias.mjBIAS_NONE))
            & (model.actuator_dyntype == int(kinds.mjtDyn.mjDYN_NONE))
        )
        force = model.actuator_gainprm[:, 0] * model.actuator_gear[:, 0]
        found = np.flatnonzero(plain & (force != 0.0))
        if len(found) != 1:
            raise InputError(
                f"Tendon `{name}` needs exactly one actuator that turns control into force, but "
                f"the model has {len(found)}; add the line {LINE.format(name)}"
            )
        (index,) = found
        if model.actuator_ctrllimited[index] or model.actuator_forcelimited[index]:
            raise InputError(
                f"The actuator of tendon `{name}` limits its control or force; leave out "
                "`ctrlrange` and `forcerange`: what limits the tension is the element."
            )
        return int(index), float(force[index])


def scalar_joints(model: Any, joints: Sequence[str] | None) -> dict[str, int]:
    """Where the position of each hinge or slide stands among the coordinates; all if None.

    Raises:
        UnknownNameError: there is no hinge or slide of that name.
    """
    kinds = load_mujoco().mjtJoint
    simple = (int(kinds.mjJNT_HINGE), int(kinds.mjJNT_SLIDE))
    known = {
        model.joint(i).name: int(model.jnt_qposadr[i])
        for i in range(model.njnt)
        if model.jnt_type[i] in simple and model.joint(i).name
    }
    for name in joints or ():
        if name not in known:
            raise UnknownNameError("hinge or slide", name, known)
    return known if joints is None else {name: known[name] for name in joints}
