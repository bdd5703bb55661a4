"""Step a MuJoCo model with elements under waveforms, and record it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from martensite.base.errors import InputError, ParameterError, SolveError, require_known
from martensite.export.mujoco_models import find_joints, load_mujoco
from martensite.export.mujoco_result import MujocoResult
from martensite.export.strand import TracedStrand
from martensite.signals.base import AbstractWaveform
from martensite.signals.constant import Constant
from martensite.simulate.grid import MOST_STEPS, place_signal, require_unit

if TYPE_CHECKING:
    from martensite.export.mujoco_actuators import MujocoActuators

Waves = Mapping[str, AbstractWaveform]


def run_actuators(
    actuators: MujocoActuators,
    duration: float,
    signals: Mapping[str, AbstractWaveform | float],
    data: Any,
    samples: int,
    joints: Sequence[str] | None,
) -> MujocoResult:
    """Make steps and record them; arguments and errors as for `MujocoActuators.run`."""
    model = actuators.model
    waves, dt = _read_waveforms(actuators, signals, duration), float(model.opt.timestep)
    steps = max(1, math.ceil(duration / dt - 1e-9))
    if samples < 2 or steps > MOST_STEPS:
        raise InputError(f"A run has 2 samples or more, and at most {MOST_STEPS:,} steps.")
    places, every = find_joints(model, joints), math.ceil(steps / (samples - 1))
    parts = {one.name: dt * place_signal(one.system.source.sets_temperature) for one in actuators.strands}
    now, result = dict.fromkeys(waves, 0.0), MujocoResult(dt)
    for k in range(steps + 1):
        _set_controls(data, waves, now)
        rows = actuators.observe(data)
        result.follow(float(data.time), rows)
        if k % every == 0 or k == steps:
            result.sample(data, rows, places)
        if k < steps:
            _set_controls(data, waves, parts)
            _make_step(actuators, data, result)
    for strand in actuators.strands:
        result.judge(strand)
    return result


def _make_step(actuators: MujocoActuators, data: Any, result: MujocoResult) -> None:
    time, faults = float(data.time), _count_faults(data)
    load_mujoco().mj_step(actuators.model, data)
    actuators.require_solved()
    if not data.time > time or _count_faults(data) != faults:  # MuJoCo restarts the model
        raise SolveError(
            f"MuJoCo found the motion of the model unstable at t = {time:.6g} s. "
            "Try a smaller `timestep`, or more damping or armature of light joints."
        )
    result.note_crossing(time, max(one.crossing for one in actuators.list_steps(data)))


def _count_faults(data: Any) -> int:
    kinds = load_mujoco().mjtWarning
    bad = (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC)
    return sum(data.warning[int(kind)].number for kind in bad)


def _set_controls(data: Any, waves: Waves, later: Mapping[str, float]) -> None:
    """Set each control to its signal, `later` [s] after the time of the data."""
    for name, wave in waves.items():
        data.actuator(name).ctrl = wave.value(float(data.time) + later[name])


def _read_waveforms(
    actuators: MujocoActuators, signals: Mapping[str, AbstractWaveform | float], duration: float
) -> Waves:
    if not 0.0 < duration < math.inf:
        raise ParameterError(f"Argument `duration` must be above 0 s, but is {duration}.")
    for name in signals:
        require_known("tendon with an element is", name, actuators.tendons)
    missing = [name for name in actuators.tendons if name not in signals]
    if missing:
        raise InputError(f"A signal is missing for tendon {', '.join(missing)}.")
    step = float(actuators.model.opt.timestep)
    return {one.name: _read_waveform(one, signals[one.name], duration, step) for one in actuators.strands}


def _read_waveform(
    strand: TracedStrand, signal: AbstractWaveform | float, duration: float, step: float
) -> AbstractWaveform:
    wave = signal if isinstance(signal, AbstractWaveform) else Constant(level=signal)
    require_unit(wave, strand.system.source.unit)
    if len(wave.edges(duration)) * step > duration:
        raise InputError(
            f"The waveform for tendon `{strand.name}` has more than one edge per time "
            f"step of {step:.3g} s; set a smaller `timestep` in the model."
        )
    return wave
