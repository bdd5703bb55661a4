r"""MuJoCo models moved by shape-memory elements: a tendon with an element of its own, or several.

Over a step dt the length of a tendon is a function of the tensions F in force during it,

    l_i(F) ≈ l_i(F*) - Σ_j S_ij (F_j - F*_j),        S = -∂l/∂F = dt² J M⁻¹ Jᵀ  for free motion,

with J the Jacobian of the lengths and M the mass matrix. MuJoCo itself is asked for l(F*) and S
(`martensite.export.mujoco_plant`), so damping, contacts, joint limits and the integrator are in
them. To an element that is a load line. It solves law, heat and force together on it, tension
only: no force lags behind the motion, nor behind the phase state that it belongs to. Several
elements are balanced with each other (`martensite.export.balance`). Then MuJoCo is asked where the
forces lead; if the line was not straight (a contact closes), the next one is laid there.

Which force acts during the step is a choice:

    end       F = f₁                        stable at any step; takes the share ω dt/2 of critical
                                            damping from an oscillation of angular frequency ω
                                            (implicit Euler); the default
    centred   F = (f₁ + 2 f₀ + f₋₁)/4       second order, damps nothing (trapezoidal rule), and
                                            so rings where ω dt is above 1

with f₀, f₁ the force of the element at the start and at the end, f₋₁ one step before start.
MuJoCo's velocities belong to half steps (q₁ = q₀ + dt v₁): f₁ alone is of first order.

Sign convention: tension and shortening positive. SI throughout.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from martensite.actuators.assembly import Actuator
from martensite.base.errors import InputError, ParameterError, SolveError, UnknownNameError, suggest_name
from martensite.base.parameters import Number, param, part
from martensite.export.balance import solve_nonnegative
from martensite.export.mujoco_plant import TendonPlant, load_mujoco, scalar_joints
from martensite.export.mujoco_result import MujocoResult
from martensite.export.mujoco_step import Solved, solve_step
from martensite.export.strand import CENTRED, END, TracedStrand
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.simulate.grid import MOST_STEPS, place_signal, require_unit

COUPLINGS = {"end": END, "centred": CENTRED}
TRIED = 1.0
"""Difference of a tension by which slopes are measured [N]."""
WEAK = 1e-9
"""Share of the largest slope that is added to all, so that tendons may balance each other."""
HELD = 1e-3
"""Share of the motion without tensions that may be left."""


class TendonActuator(Actuator):
    """An element along a tendon of a MuJoCo model, with its environment and its source.

    In the pose in which the bridge starts it is under `start_force`, or loose by `slack`.
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


class MujocoBridge:
    """A MuJoCo model with shape-memory elements along its tendons.

    Args:
        model: an `MjModel`, or the path of an MJCF file, or MJCF text.
        actuators: one per tendon; other tendons of the model are left alone.
        data: the `MjData` to move, from the state it is in; by default a new one.
        keyframe: name of the keyframe in which a new one starts.
        coupling: `end` or `centred`, which force of an element acts during a step.

    Raises:
        InputError: MuJoCo is missing, or the model cannot be driven so; the sentence says why.
    """

    def __init__(
        self,
        model: Any,
        actuators: Sequence[TendonActuator],
        *,
        data: Any = None,
        keyframe: str | None = None,
        coupling: str = "end",
    ) -> None:
        if coupling not in COUPLINGS:
            raise InputError(f"No coupling `{coupling}`. {suggest_name(coupling, COUPLINGS)}")
        tendons = [actuator.tendon for actuator in actuators]
        if not tendons or len(set(tendons)) < len(tendons):
            raise InputError("A bridge needs actuators, each at a tendon of its own.")
        self.model = read_model(model)
        self.data = begin_data(self.model, keyframe) if data is None else data
        self.weights = COUPLINGS[coupling]
        self.plant = TendonPlant(self.model, self.data, tendons)
        self.strands = [
            TracedStrand(one.tendon, one, one.start_force, one.slack, length)
            for one, length in zip(actuators, self.plant.lengths(), strict=True)
        ]

    def step(self, signals: Mapping[str, float]) -> Solved:
        """Advance by the time step of the model under one signal per tendon, in its unit.

        Returns how the step was solved.

        Raises:
            InputError: a signal is missing, or is for no tendon of the bridge.
            SolveError: the step failed; the sentence says when, where and what to try.
        """
        self._match(signals)
        drives = [float(signals[strand.name]) for strand in self.strands]
        if not all(map(math.isfinite, drives)):
            raise InputError(f"Signals must be finite, but are {drives}.")
        time, solved = self.plant.time, solve_step(self.plant, self.strands, self.weights, drives)
        lengths = self.plant.advance(solved.tensions)
        rows = zip(self.strands, solved.answers, drives, lengths, strict=True)
        for strand, answer, drive, length in rows:
            strand.commit(answer, drive, length, time)
        return solved

    def observe(self, signals: Mapping[str, float] | None = None) -> dict[str, dict[str, float]]:
        """What can be measured now, in SI, by tendon and output.

        Args:
            signals: drive signals to measure under; by default those of the last step.
        """
        found: dict[str, dict[str, float]] = {}
        for strand, length in zip(self.strands, self.plant.lengths(), strict=True):
            drive = strand.drive if signals is None else float(signals[strand.name])
            found[strand.name] = strand.observe(drive) | {"length": length}
        return found

    def run(
        self,
        duration: float,
        signals: Mapping[str, AbstractWaveform | float],
        *,
        samples: int = 1001,
        joints: Sequence[str] | None = None,
    ) -> MujocoResult:
        """Go on for `duration` [s], in whole steps of the model.

        A step takes the signal at its middle (at its end if that is a temperature), at the time
        of the model. Steps do not end on the edges of a waveform: choose the time step so.

        Args:
            duration: length of the run [s]; rounded up to whole steps.
            signals: a waveform or a constant per tendon, in the unit of its source.
            samples: most samples returned; they are a whole number of steps apart.
            joints: hinges and slides whose positions are returned; by default all.

        Raises:
            InputError: an argument is out of range.
            SolveError: the run failed; the sentence says when, where and what to try.
        """
        waves = self._waveforms(signals, duration)
        steps = max(1, math.ceil(duration / self.plant.dt - 1e-9))
        if samples < 2 or steps > MOST_STEPS:
            raise InputError(f"A run has 2 samples or more, and at most {MOST_STEPS:,} steps.")
        places, every = scalar_joints(self.model, joints), math.ceil(steps / (samples - 1))
        result = MujocoResult(self.plant.dt)
        self._observe(result, waves, places)
        for k in range(1, steps + 1):
            time = self.plant.time
            solved = self.step(self._signals(waves, time))
            worst = max(strand.status for strand in self.strands)
            result.note(worst, time, solved.error, solved.turns, solved.asked)
            self._observe(result, waves, places if k % every == 0 or k == steps else None)
        for strand in self.strands:
            result.judge(strand)
        return result

    def _observe(
        self, result: MujocoResult, waves: Mapping[str, AbstractWaveform], places: dict[str, int] | None
    ) -> None:
        """Follow what alarms are about, and keep a sample if `places` of joints are given."""
        rows = self.observe({name: wave.value(self.plant.time) for name, wave in waves.items()})
        result.follow(self.plant.time, rows)
        if places is not None:
            result.sample(self.data, rows, places)

    def _signals(self, waves: Mapping[str, AbstractWaveform], time: float) -> dict[str, float]:
        found: dict[str, float] = {}
        for strand in self.strands:
            part = place_signal(strand.system.source.sets_temperature)
            found[strand.name] = waves[strand.name].value(time + part * self.plant.dt)
        return found

    def _waveforms(
        self, signals: Mapping[str, AbstractWaveform | float], duration: float
    ) -> dict[str, AbstractWaveform]:
        if not 0.0 < duration < math.inf:
            raise ParameterError(f"Argument `duration` must be above 0 s, but is {duration}.")
        self._match(signals)
        found: dict[str, AbstractWaveform] = {}
        for strand in self.strands:
            given = signals[strand.name]
            wave = given if isinstance(given, AbstractWaveform) else Constant(level=given)
            require_unit(wave, strand.system.source.unit)
            if len(wave.edges(duration)) * self.plant.dt > duration:
                raise InputError(
                    f"The waveform for tendon `{strand.name}` has more than one edge per time "
                    f"step of {self.plant.dt:.3g} s; set a smaller `timestep` in the model."
                )
            found[strand.name] = wave
        return found

    def _match(self, signals: Mapping[str, object]) -> None:
        tendons = [strand.name for strand in self.strands]
        for name in signals:
            if name not in tendons:
                raise UnknownNameError("tendon of the bridge is", name, tendons)
        missing = [name for name in tendons if name not in signals]
        if missing:
            raise InputError(f"A signal is missing for tendon {', '.join(missing)}.")


def read_model(model: Any) -> Any:
    """An `MjModel` from one, from the path of an MJCF file, or from MJCF text.

    Raises:
        InputError: MuJoCo cannot read it.
    """
    kind = load_mujoco().MjModel
    return read_mjcf(model, kind, kind.from_xml_string, kind.from_xml_path)


def read_mjcf(model: Any, kind: type, from_text: Callable[[str], Any], from_file: Callable[[str], Any]) -> Any:
    """What MuJoCo makes of the path of an MJCF file, or of MJCF text; one of the `kind` already is itself.

    Raises:
        InputError: MuJoCo cannot read it.
    """
    if isinstance(model, kind):
        return model
    text = isinstance(model, str) and model.lstrip().startswith("<")
    if not text and not Path(model).is_file():
        raise InputError(f"There is no MJCF file `{model}`.")
    try:
        return from_text(model) if text else from_file(str(model))
    except ValueError as error:
        raise InputError(f"MuJoCo cannot read the model: {error}") from error


def begin_data(model: Any, keyframe: str | None) -> Any:
    """New data, in a keyframe if one is named."""
    mujoco = load_mujoco()
    data = mujoco.MjData(model)
    if keyframe is not None:
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, keyframe)
        if index < 0:
            known = [model.key(i).name for i in range(model.nkey)]
            raise UnknownNameError("keyframe of the model is", keyframe, known)
        mujoco.mj_resetDataKeyframe(model, data, index)
    return data


def holding_tensions(
    model: Any, tendons: Sequence[str], *, data: Any = None, keyframe: str | None = None
) -> dict[str, float]:
    """Tensions [N] that hold a model still at its tendons; the `start_force` of its elements.

    Of a step from rest MuJoCo is asked how far the tendons get, without tensions and with them. Where several tendons
    can share a load, the smallest tensions (in the sum of squares) are taken: add to them what should be preload.

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
