"""Systems as MJCF, the model format of MuJoCo, and as MuJoCo models driven by their elements.

The model of a mechanism in `WRITERS` has a tendon named after each port, and joints named after the coordinates.
`to_mujoco` adds the shape-memory elements along the tendons.

A mechanism without inertia (`motion = "quasi-static"`) gets the inertia of its parameters.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.finger import Finger
from martensite.actuators.mechanisms.parallel_platform import ParallelPlatform
from martensite.base.errors import InputError, ParameterError
from martensite.export.mjcf_finger import write_finger
from martensite.export.mjcf_model import Model, new_model
from martensite.export.mjcf_platform import write_platform
from martensite.export.mujoco_actuators import MujocoActuators, TendonActuator
from martensite.kernels import floats
from martensite.signals.base import AbstractWaveform
from martensite.simulate.drive_waveforms import Waveforms, arrange_waveforms

TIMESTEP = 2e-3
"""Default time step of MuJoCo [s]."""

Writer = Callable[[Model, Any, float], None]
"""Function that adds a mechanism to a model with a time step [s]."""

WRITERS: dict[type[AbstractMechanism], Writer] = {Finger: write_finger, ParallelPlatform: write_platform}
"""Writer by mechanism; a subclass can have other equations and needs a separate writer."""


def to_mjcf(system: AbstractSystem, *, timestep: float = TIMESTEP) -> str:
    """Return the mechanism of a system as MJCF text, with a tendon for each element.

    Args:
        system: a `System` or a `Machine`.
        timestep: time step of the model [s].

    Raises:
        InputError: the mechanism has no writer, or a feature that MuJoCo lacks.
    """
    return model_of(system, timestep=timestep).text()


def model_of(system: AbstractSystem, *, timestep: float = TIMESTEP) -> Model:
    """Return the sections of the document of `to_mjcf`, with the same errors."""
    if not 0.0 < timestep < 1.0:
        raise ParameterError(f"Argument `timestep` must be above 0 s and below 1 s, but is {timestep:.6g}.")
    mechanism = system.mechanism
    write = WRITERS.get(type(mechanism))
    if write is None:
        writable = ", ".join(f"`{cls.registered_name}`" for cls in WRITERS)
        raise InputError(
            f"Mechanism `{mechanism.registered_name}` cannot be written as MJCF; those that can: {writable}. Any model "
            "of your own can be driven by `MujocoActuators`; `martensite export mujoco --snippet` writes what it needs."
        )
    model = new_model(str(mechanism.registered_name), timestep)
    write(model, mechanism, timestep)
    return model


def to_mujoco(system: AbstractSystem, *, timestep: float = TIMESTEP, coupling: str = "centred") -> MujocoActuators:
    """Build a MuJoCo model of a system, with its elements as actuators.

    The elements start as in a run of the system. Run it under `tendon_signals(system, waveform)`.

    Args:
        system: a `System` or a `Machine`.
        timestep: time step of the model [s].
        coupling: `centred` is of second order, as runs of a system are; `end` is stable at any step.

    Returns:
        The model of `to_mjcf` with an actuator at each tendon.

    Raises:
        InputError: the system cannot be written as MJCF, or MuJoCo is missing.
        CompileError: a C compiler is missing.
    """
    forces = start_forces(system)
    actuators = [
        TendonActuator(
            tendon=port, element=one.element, environment=one.environment, source=one.source, start_force=forces[port]
        )
        for port, one in system.actuators().items()
    ]
    return MujocoActuators(to_mjcf(system, timestep=timestep), actuators, coupling=coupling)


def start_forces(system: AbstractSystem) -> dict[str, float]:
    """Return the force of the element at each port at assembly [N]."""
    if getattr(system, "supply", None) is not None:
        raise InputError(
            "A `supply` that several sources share is not known to a model of MuJoCo, in which every element is on its "
            "own; leave it out, or give every source its own limits."
        )
    forces = zip(system.actuators(), system.mechanism.start_forces(floats), strict=True)
    return {port: float(force) for port, force in forces}


def tendon_signals(system: AbstractSystem, waveform: Waveforms) -> dict[str, AbstractWaveform]:
    """Return the waveforms of a run by tendon; missing ones are 0.

    Args:
        system: the argument of `to_mujoco`.
        waveform: as for `simulate`, such as the `waveform` of a scenario.

    Raises:
        InputError: a name or a unit does not fit.
    """
    return dict(zip(system.actuators(), arrange_waveforms(system, waveform), strict=False))
