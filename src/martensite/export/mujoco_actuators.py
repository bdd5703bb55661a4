r"""Elements as actuators of somebody's own MuJoCo model, as cheap as any other: C that MuJoCo calls by itself.

`mj_step` asks for the bias of an actuator of type `user` by a callback (`mjcb_act_bias`), here C made of the kernel of
the element. The force is found on a load line, together with law and heat, as in `martensite.export.mujoco_bridge`:

    l(F) = l + dt J (v + dt (M + dt D)⁻¹ (f - Jᵀ F))

but the line is laid by the mass matrix that MuJoCo has at hand, with contacts and limits of one step ago, in place of
trial steps. So a step of the model is made once, and may be made by anybody: `mj_step`, a viewer, another program's
loop. What an element remembers stands in `userdata` of the data, and goes with its copies and saved states.

Sign convention: tension and shortening positive; a tension is a negative `actuator_force`. SI throughout.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from martensite.base.errors import InputError, SolveError, UnknownNameError
from martensite.export.c_kernels import CKernel, kernels_text, precision_of
from martensite.export.mujoco_bridge import TendonActuator, begin_data, read_mjcf
from martensite.export.mujoco_plant import load_mujoco
from martensite.export.strand import TracedStrand
from martensite.kernels.compiled_program import get_address
from martensite.kernels.compiler import load_library
from martensite.simulate.compiled import Compiled, compile_system

HEAD, OWN = 2, 4
"""Numbers in `userdata` for a group, and for each of its elements besides its states."""
NUMBERS = {"SOLVED": 1e-8, "AGREED": 1e-10, "LEAST": 1e-3, "TURNS": 50, "SWEEPS": 200, "MOST": 4096}
"""Residual of a solved element; change of a force at which elements are balanced, as a share and of what force [N] at
least; turns and sweeps until then; groups of elements in one process."""
FAILURES = {
    1: "the element at tendon `{}` was not solved; try a smaller `timestep`, and look at its drive",
    2: "the forces of elements that share joints were not balanced; try a smaller `timestep`",
    3: "time went back but `userdata` did not; restore both, as `mj_setState` does with mjSTATE_INTEGRATION",
    4: "the integrator asks for forces within a step; use Euler, implicit or implicitfast",
    5: "there was no memory left",
}
OLDEST = 4
"""Version of MuJoCo whose structures the C is written for."""


class StrandStep(NamedTuple):
    """What an element did in the step whose time is the newest."""

    drive: float
    reach: float
    """Where the path would have ended without force, above the length without elongation [m]."""
    give: float
    """How much it yields [m/N]."""
    force: float
    """[N]"""
    start: tuple[float, ...]
    """State before the step."""
    end: tuple[float, ...]
    """State after it."""


class MujocoActuators:
    """A model of MuJoCo with elements along its tendons, as actuators that any program steps.

    `model` has an actuator for each, named as its tendon, behind those that it had; its control is the drive signal, in
    the unit of its source. MuJoCo's `mjcb_act_bias` is taken for the whole process.

    Args:
        model: path of an MJCF file, MJCF text, or an `MjSpec`, to which the actuators are added.
        actuators: one per tendon.
        keyframe: name of the keyframe in whose pose each element is under its `start_force`; by default the pose of
            the model.

    Raises:
        InputError: MuJoCo is missing or too old, or the model cannot be driven so; the sentence says why.
        CompileError: there is no C compiler.
    """

    def __init__(self, model: Any, actuators: Sequence[TendonActuator], *, keyframe: str | None = None) -> None:
        require_mujoco()
        self.tendons = [one.tendon for one in actuators]
        if not actuators or len(set(self.tendons)) < len(actuators):
            raise InputError("There must be actuators, each at a tendon of its own.")
        spec = read_spec(model)
        bare = spec.compile()
        self.strands = trace_strands(bare, begin_data(bare, keyframe), actuators)
        compiled = [compile_system(one.system) for one in self.strands]
        self._library = load_library(write_source(compiled), list_flags())
        self._first = spec.nuserdata
        *self._places, end = place_strands(compiled, self._first + HEAD)
        self._group = self._make_group(compiled)
        number = load_dispatcher().add_group(self._library.find_force, self._group)
        self.model = add_actuators(spec, self.tendons, (number, self._first), end)

    def _make_group(self, compiled: Sequence[Compiled]) -> Any:
        self._library.make_group.restype = ctypes.c_void_p
        group = ctypes.c_void_p(self._library.make_group())
        for k, (one, strand) in enumerate(zip(compiled, self.strands, strict=True)):
            told = [np.array(row, float) for row in ((strand.reference, strand.force), strand.state)]
            told.append(np.array(one.values(strand.system), float))
            self._library.set_strand(group, k, self._places[k] - self._first, *map(get_address, told))
        return group

    def observe(self, data: Any) -> dict[str, dict[str, float]]:
        """What can be measured now, in SI, by tendon and output, under the present controls.

        Raises:
            SolveError: a step failed since the last call; the sentence says when and why.
        """
        self.require_solved()
        found: dict[str, dict[str, float]] = {}
        for strand, step in zip(self.strands, self.list_steps(data), strict=True):
            length = float(data.actuator(strand.name).length[0])
            strand.state = step.end if self._has_moved(data) else step.start
            strand.line = length - strand.reference, 0.0
            found[strand.name] = strand.observe(float(data.actuator(strand.name).ctrl[0])) | {"length": length}
        return found

    def list_steps(self, data: Any) -> list[StrandStep]:
        """What each element did in the newest step of the data, in the order of `tendons`."""
        return [self._read_step(data.userdata, *one) for one in zip(self.strands, self._places, strict=True)]

    def _read_step(self, kept: Any, strand: TracedStrand, place: int) -> StrandStep:
        if kept[self._first] == 0.0:  # not begun
            return StrandStep(strand.drive, *strand.line, strand.force, strand.state, strand.state)
        force, drive, reach, give = kept[place : place + OWN].tolist()
        size = len(strand.state)
        states = kept[place + OWN : place + OWN + 2 * size].tolist()
        return StrandStep(drive, reach, give, force, tuple(states[:size]), tuple(states[size:]))

    def _has_moved(self, data: Any) -> bool:
        """Whether time is beyond the start of the newest step."""
        return bool(data.time > data.userdata[self._first + 1])

    def require_solved(self) -> None:
        """Raise `SolveError` if a step failed since the last call; its forces were no numbers."""
        time, strand = ctypes.c_double(), ctypes.c_int()
        failed = self._library.read_failure(self._group, ctypes.byref(time), ctypes.byref(strand))
        if failed:
            said = FAILURES[failed].format(self.tendons[strand.value])
            raise SolveError(f"A step of the model failed at t = {time.value:.6g} s: {said}.")


def require_mujoco() -> None:
    """Raise `InputError` unless MuJoCo is there, and not too old."""
    version = load_mujoco().__version__
    if int(version.split(".")[0]) < OLDEST:
        raise InputError(
            f"Actuators in C need MuJoCo {OLDEST} or newer, but {version} is installed; use `MujocoBridge`."
        )


def read_spec(model: Any) -> Any:
    """An `MjSpec` from one, from the path of an MJCF file, or from MJCF text.

    Raises:
        InputError: MuJoCo cannot read it.
    """
    kind = load_mujoco().MjSpec
    return read_mjcf(model, kind, kind.from_string, kind.from_file)


def trace_strands(model: Any, data: Any, actuators: Sequence[TendonActuator]) -> list[TracedStrand]:
    """Elements along the tendons of a model, in the pose of its data.

    Raises:
        InputError: there is no such tendon, nothing is actuated, or the integrator asks for forces within a step.
    """
    mujoco = load_mujoco()
    if model.opt.integrator not in (
        mujoco.mjtIntegrator.mjINT_EULER,
        mujoco.mjtIntegrator.mjINT_IMPLICIT,
        mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    ):
        raise InputError("Elements are solved once in a step: set `integrator` to Euler, implicit or implicitfast.")
    if model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_ACTUATION):
        raise InputError("The model disables actuation: its tendons cannot be driven.")
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_tendon(model, data)
    known = [model.tendon(k).name for k in range(model.ntendon)]
    for one in actuators:
        if one.tendon not in known:
            raise UnknownNameError("tendon of the model is", one.tendon, known)
    lengths = [float(data.ten_length[known.index(one.tendon)]) for one in actuators]
    return [
        TracedStrand(one.tendon, one, one.start_force, one.slack, length)
        for one, length in zip(actuators, lengths, strict=True)
    ]


def place_strands(compiled: Sequence[Compiled], first: int) -> list[int]:
    """Where in `userdata` each element keeps what it remembers, and where the last one ends."""
    found = [first]
    for one in compiled:
        found.append(found[-1] + OWN + 2 * one.size)
    return found


def add_actuators(spec: Any, tendons: Sequence[str], group: tuple[int, int], end: int) -> Any:
    """The compiled model of a specification, with an actuator for each tendon.

    Args:
        spec: to which they are added.
        tendons: their names.
        group: number and first place in `userdata`.
        end: first place in `userdata` that is free.

    Raises:
        InputError: MuJoCo cannot make it.
    """
    mujoco = load_mujoco()
    for k, tendon in enumerate(tendons):
        one = spec.add_actuator(name=tendon, trntype=mujoco.mjtTrn.mjTRN_TENDON, target=tendon)
        one.gaintype, one.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_USER
        one.dyntype, one.gainprm[0], one.gear[:] = mujoco.mjtDyn.mjDYN_NONE, 0.0, (1.0, *[0.0] * 5)
        one.ctrllimited = one.forcelimited = one.actlimited = 0  # whatever the defaults of the model are
        one.biasprm[:3] = group[0], k, group[1]
    spec.nuserdata = end
    try:
        return spec.compile()
    except ValueError as error:
        raise InputError(f"MuJoCo cannot make the model: {error}") from error


# ---------------------------------------------------------------- C


def list_flags() -> tuple[str, ...]:
    """Where the headers of MuJoCo are."""
    return (f"-I{Path(load_mujoco().__file__).parent / 'include'}",)


def write_source(compiled: Sequence[Compiled]) -> str:
    """C of all elements: each kernel once, tables of what is whose, and the step."""
    texts, kinds = list[str](), dict[int, int]()
    for one in compiled:
        if id(one.program) not in kinds:
            kinds[id(one.program)] = len(kinds)
            kernel = CKernel.of(one.program.functions["step"], one.size, 3)
            kept = list(range(len(one.program.parameters)))
            texts.append(
                kernels_text(one.program, kept, [kernel], f"k{kinds[id(one.program)]}_", precision_of("float64"))
            )
    numbers = NUMBERS | {
        "STRANDS": len(compiled),
        "KEPT": max(one.size for one in compiled),
        "CONSTANTS": max(1, *(one.program.constants for one in compiled)),
    }
    mine = [kinds[id(one.program)] for one in compiled]
    tables = [
        f"#define STEPS ((const Kernel[]){{{', '.join(f'k{k}_kernel_step' for k in mine)}}})",
        f"#define PREPARES ((const Prepare[]){{{', '.join(f'k{k}_kernel_prepare' for k in mine)}}})",
        f"#define STATES ((const int[]){{{', '.join(str(one.size) for one in compiled)}}})",
    ]
    return "\n".join([*define_numbers(numbers), *texts, *tables, read_text("mujoco_callback.c")])


def define_numbers(numbers: dict[str, Any]) -> list[str]:
    """Headers, and constants by name."""
    heads = ["float.h", "math.h", "stdlib.h", "string.h", "mujoco/mujoco.h"]
    return [*(f"#include <{name}>" for name in heads), *(f"#define {key} {value}" for key, value in numbers.items())]


def read_text(name: str) -> str:
    """C of a file of this package."""
    return (Path(__file__).parent / name).read_text(encoding="utf-8")


@cache
def load_dispatcher() -> Any:
    """The library whose callback MuJoCo has from now on, once in a process.

    Raises:
        InputError: another program has that callback.
    """
    mujoco = load_mujoco()
    if mujoco.get_mjcb_act_bias() is not None:
        raise InputError("MuJoCo's callback `mjcb_act_bias` is taken; set it to None first.")
    library = load_library(
        "\n".join([*define_numbers({"MOST": NUMBERS["MOST"]}), read_text("mujoco_dispatch.c")]), list_flags()
    )
    mujoco.set_mjcb_act_bias(library.find_bias)
    return library
