"""Shape-memory elements as actuators of a MuJoCo model, in C that `mj_step` calls.

`mj_step` gets the bias of an actuator of type `user` from a callback (`mjcb_act_bias`). Here the callback is C
generated from the kernel of the element. The force is solved on a load line, together with law and heat:

    l(F) = l + dt J (v + dt (M + dt D)⁻¹ (f - Jᵀ F))

with the length l of the tendon, its Jacobian J, the mass matrix M, the joint damping D and the smooth forces f. Contact
and limit forces are those of the previous step. The force that acts in a step depends on `coupling`:

    end       F = f₁                        stable at any step, first order; damps an oscillation of angular frequency
                                            ω by the fraction ω dt/2 of critical damping (implicit Euler)
    centred   F = (f₁ + 2 f₀ + f₋₁)/4       second order, no damping (trapezoidal rule); rings if ω dt > 1

with f₀, f₁ the force of the element at the start and at the end, f₋₁ one step before the start. MuJoCo's velocities
belong to half steps, so f₁ alone is of first order.

`mj_step`, a viewer or another program can make the steps. The memory of an element is in `userdata` of the data, so
copies and saved states contain it.

Sign convention: tension and shortening are positive; a tension is a negative `actuator_force`. SI units.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from martensite.actuators.assembly import Actuator
from martensite.base.errors import InputError, ParameterError, SolveError, require_known
from martensite.base.parameters import Number, param, part
from martensite.export.mujoco_models import (
    add_tendon_actuator,
    begin_data,
    compile_spec,
    find_tendons,
    load_mujoco,
    measure_tendons,
    read_spec,
)
from martensite.export.mujoco_result import MujocoResult
from martensite.export.mujoco_run import run_actuators
from martensite.export.mujoco_source import list_flags, load_dispatcher, write_source
from martensite.export.strand import TracedStrand
from martensite.kernels.compiled_program import get_address
from martensite.kernels.compiler import load_library
from martensite.signals.base import AbstractWaveform
from martensite.simulate.compiled import CompiledSystem, compile_system

HEAD, OWN = 2, 7
"""Numbers in `userdata` for a group, and for each of its elements in addition to its states."""
COUPLINGS = {"end": (1.0, 0.0, 0.0), "centred": (0.25, 0.5, 0.25)}
"""Weights of the forces that act in a step: at its end, at its start, one step earlier."""
FAILURES = {
    1: "the element at tendon `{}` was not solved; try a smaller `timestep`, and look at its drive",
    2: "the forces of elements that share joints were not balanced; try a smaller `timestep`",
    3: "time went back but `userdata` did not; restore both, as `mj_setState` does with mjSTATE_INTEGRATION",
    4: "the integrator asks for forces within a step; use Euler, implicit or implicitfast",
    5: "there was no memory left",
}


class TendonActuator(Actuator):
    """An element along a tendon of a MuJoCo model, with its environment and its source.

    At the start of the model it has `start_force`, or is loose by `slack`.
    """

    tendon: str = part("name of the tendon")
    start_force: Number = param("N", "force at the start", low=0.0, high=1e6, default=0.0)
    slack: Number = param("m", "how much the tendon is shorter than the element at the start", low=0.0, default=0.0)

    def check(self) -> None:
        """Raise `ParameterError` for an element that is loose and under force."""
        if self.slack > 0.0 and self.start_force > 0.0:
            raise ParameterError(
                f"The element at tendon `{self.tendon}` cannot have both `start_force` and "
                "`slack`; leave one of them out."
            )


class StrandStep(NamedTuple):
    """An element in the newest step."""

    drive: float
    reach: float
    """Elongation [m] at which the path would end without force."""
    give: float
    """Compliance of the path over the step [m/N]."""
    force: float
    """At the end of the step [N]."""
    crossing: float
    """Fraction of a transformation strip that the elastic trial crossed."""
    start: tuple[float, ...]
    """State before the step."""
    end: tuple[float, ...]
    """State after the step."""


class MujocoActuators:
    """A MuJoCo model with elements along its tendons, as actuators that any program can step.

    `model` has an additional actuator for each element, named after its tendon, after its other actuators. Its control
    is the drive signal, in the unit of the source. MuJoCo's `mjcb_act_bias` is set for the whole process.

    Args:
        model: the path of an MJCF file, MJCF text, or an `MjSpec`, which is not changed.
        actuators: one per tendon; other tendons of the model are not changed.
        keyframe: name of the keyframe in which each element has its `start_force`; by default the pose of the model.
        coupling: `end` or `centred`, the force of an element that acts in a step.

    Raises:
        InputError: MuJoCo is missing or too old, or cannot drive this model.
        CompileError: a C compiler is missing.
    """

    def __init__(
        self, model: Any, actuators: Sequence[TendonActuator], *, keyframe: str | None = None, coupling: str = "end"
    ) -> None:
        require_known("coupling", coupling, COUPLINGS)
        self.tendons = [one.tendon for one in actuators]
        if not actuators or len(set(self.tendons)) < len(actuators):
            raise InputError("There must be actuators, each at its own tendon.")
        spec = read_spec(model)
        bare = compile_spec(spec)
        self.strands = trace_strands(bare, begin_data(bare, keyframe), actuators)
        compiled = [compile_system(one.system) for one in self.strands]
        self._library = load_library(write_source(compiled), list_flags())
        self._first, self._keyframe = spec.nuserdata, keyframe
        *self._places, end = place_strands(compiled, self._first + HEAD)
        self._group = self._make_group(compiled, COUPLINGS[coupling])
        number = load_dispatcher().add_group(self._library.find_force, self._group)
        self.model = add_actuators(spec, self.tendons, (number, self._first), end)
        self._numbers = find_tendons(self.model, self.tendons)

    def _make_group(self, compiled: Sequence[CompiledSystem], weights: Sequence[float]) -> Any:
        self._library.make_group.restype = ctypes.c_void_p
        group = ctypes.c_void_p(self._library.make_group(get_address(np.array(weights))))
        for k, (one, strand) in enumerate(zip(compiled, self.strands, strict=True)):
            rows = [np.array(row, float) for row in ((strand.reference, strand.force), strand.state)]
            rows.append(np.array(one.values(strand.system), float))
            self._library.set_strand(group, k, self._places[k] - self._first, *map(get_address, rows))
        return group

    def begin(self) -> Any:
        """Return new data (`MjData`) in the start pose of the elements."""
        return begin_data(self.model, self._keyframe)

    def observe(self, data: Any) -> dict[str, dict[str, float]]:
        """Measure all elements at the present time, coordinates and controls.

        Args:
            data: `MjData` of the model. Its tendon lengths are updated.

        Returns:
            Outputs in SI by tendon and name, including the `length` of the tendon [m].

        Raises:
            SolveError: a step failed since the last call.
        """
        self.require_solved()
        lengths = measure_tendons(self.model, data)[self._numbers].tolist()
        rows: dict[str, dict[str, float]] = {}
        for strand, step, length in zip(self.strands, self.list_steps(data), lengths, strict=True):
            state, drive = step.end if self._has_moved(data) else step.start, data.actuator(strand.name).ctrl[0]
            rows[strand.name] = strand.observe(state, float(drive), length) | {"length": length}
        return rows

    def run(
        self,
        duration: float,
        signals: Mapping[str, AbstractWaveform | float],
        *,
        data: Any = None,
        samples: int = 1001,
        joints: Sequence[str] | None = None,
    ) -> MujocoResult:
        """Make steps for `duration` [s] and record them.

        A step uses the signal at its middle (at its end for a temperature), at the time of the data. Steps do not end
        at the edges of a waveform: choose the time step accordingly.

        Args:
            duration: length of the run [s]; rounded up to whole steps.
            signals: a waveform or a constant per tendon, in the unit of its source.
            data: `MjData` to continue from; by default new data as from `begin`.
            samples: largest number of samples; they are a whole number of steps apart.
            joints: hinges and slides whose positions are returned; by default all.

        Returns:
            Columns over time in SI, with alarms.

        Raises:
            InputError: an argument is out of range.
            SolveError: the run failed; the sentence says when, where and what to try.
        """
        return run_actuators(self, duration, signals, self.begin() if data is None else data, samples, joints)

    def list_steps(self, data: Any) -> list[StrandStep]:
        """Return the newest step of each element, in the order of `tendons`."""
        return [self._read_step(data.userdata, *one) for one in zip(self.strands, self._places, strict=True)]

    def _read_step(self, userdata: Any, strand: TracedStrand, place: int) -> StrandStep:
        if userdata[self._first] == 0.0:  # no step yet
            return StrandStep(strand.drive, strand.reach, 0.0, strand.force, 0.0, strand.state, strand.state)
        force, drive, reach, give, crossing, *_ = userdata[place : place + OWN].tolist()
        size = len(strand.state)
        states = userdata[place + OWN : place + OWN + 2 * size].tolist()
        return StrandStep(drive, reach, give, force, crossing, tuple(states[:size]), tuple(states[size:]))

    def _has_moved(self, data: Any) -> bool:
        """Return whether time is beyond the start of the newest step."""
        return bool(data.time > data.userdata[self._first + 1])

    def require_solved(self) -> None:
        """Raise `SolveError` if a step failed since the last call; its forces are NaN."""
        time, strand = ctypes.c_double(), ctypes.c_int()
        failed = self._library.read_failure(self._group, ctypes.byref(time), ctypes.byref(strand))
        if failed:
            reason = FAILURES[failed].format(self.tendons[strand.value])
            raise SolveError(f"A step of the model failed at t = {time.value:.6g} s: {reason}.")


def trace_strands(model: Any, data: Any, actuators: Sequence[TendonActuator]) -> list[TracedStrand]:
    """Trace elements along the tendons of a model, in the pose of its data."""
    integrators = load_mujoco().mjtIntegrator
    if model.opt.integrator not in (
        integrators.mjINT_EULER,
        integrators.mjINT_IMPLICIT,
        integrators.mjINT_IMPLICITFAST,
    ):
        raise InputError("Elements are solved once in a step: set `integrator` to Euler, implicit or implicitfast.")
    lengths = measure_tendons(model, data)[find_tendons(model, [one.tendon for one in actuators])].tolist()
    return [
        TracedStrand(one.tendon, one, one.start_force, one.slack, length)
        for one, length in zip(actuators, lengths, strict=True)
    ]


def place_strands(compiled: Sequence[CompiledSystem], first: int) -> list[int]:
    """Return the first index in `userdata` of each element, and the end of the last one."""
    places = [first]
    for one in compiled:
        places.append(places[-1] + OWN + 2 * one.size)
    return places


def add_actuators(spec: Any, tendons: Sequence[str], group: tuple[int, int], end: int) -> Any:
    """Compile a specification with an actuator for each tendon.

    Args:
        spec: the specification; the actuators are added to it.
        tendons: their names.
        group: number of the group, and its first index in `userdata`.
        end: first free index in `userdata`.
    """
    for k, tendon in enumerate(tendons):
        actuator = add_tendon_actuator(spec, tendon, name=tendon)
        actuator.biastype, actuator.gainprm[0] = load_mujoco().mjtBias.mjBIAS_USER, 0.0
        actuator.biasprm[:3] = group[0], k, group[1]
    spec.nuserdata = end
    return compile_spec(spec)
