"""MuJoCo models and actuators that the tests of the bridge share."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from builders import hanging_wire

from martensite.actuators.elements.wire import Wire
from martensite.export.mujoco_bridge import MujocoBridge, TendonActuator
from martensite.export.strand import ForceWeights
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.signals.base import AbstractWaveform

GRAVITY = 9.81
LAGGED = ForceWeights(0.0, 1.0, 0.0)
"""The force at the start of a step acts during it: what the bridge does not do."""

HANGING = """<mujoco>
<option timestep="{dt}" gravity="0 0 -9.81"/>
<worldbody><site name="top" pos="0 0 1"/>
  <body pos="0 0 0.7"><joint name="x" type="slide" axis="0 0 1"/>
    <geom type="sphere" size="0.01" mass="{mass}"/><site name="bottom"/></body></worldbody>
<tendon><spatial name="wire"><site site="top"/><site site="bottom"/></spatial></tendon>
<actuator><general tendon="wire" gainprm="1" biastype="none"/></actuator>
</mujoco>"""

LEVER = """<mujoco>
<option timestep="{dt}" gravity="0 0 0"/>
<worldbody><body>
  <joint name="hinge" axis="0 1 0" damping="{damping}" stiffness="{stiffness}"
         springref="{springref}" {more}/>
  <inertial pos="0 0 0" mass="0.01" diaginertia="{inertia} {inertia} {inertia}"/>
</body></worldbody>
<tendon><fixed name="wire"><joint joint="hinge" coef="{radius}"/></fixed>
        <fixed name="other"><joint joint="hinge" coef="-{radius}"/></fixed></tendon>
<actuator><general tendon="wire" gainprm="1" biastype="none"/>
          <motor tendon="other" gear="-2"/></actuator>
</mujoco>"""


def hanging(dt: float, mass: float) -> str:
    """A mass on a vertical wire."""
    return HANGING.format(dt=dt, mass=mass)


def lever(dt: float, **changes: Any) -> str:
    """A pulley of `radius` [m] between two wires, or one wire and a torsion spring."""
    usual = {"inertia": 1.8e-5, "radius": 0.004, "damping": 2e-4, "stiffness": 0.0}
    numbers = usual | {"springref": 0.0, "more": ""} | changes
    return LEVER.format(dt=dt, **numbers)


def actuator(tendon: str = "wire", *, elastic: bool = False, **changes: Any) -> TendonActuator:
    """A wire at a tendon; elastic ones are hot austenite that never transforms."""
    names = ("start_force", "slack")
    start = {name: changes.pop(name) for name in names if name in changes}
    if elastic:
        changes |= {"initial_fraction": 0.0}
    parts = hanging_wire(**changes)
    warmth = 400.0 if elastic else 293.15
    return TendonActuator(
        tendon=tendon,
        element=parts.element,
        source=parts.source,
        environment=Environment(temperature=warmth, cooling=ConstantCooling(h=150.0)),
        **start,
    )


def stiffness(one: TendonActuator) -> float:
    """Stiffness [N/m] of an elastic wire."""
    wire = one.element
    if not isinstance(wire, Wire):
        raise TypeError("not a wire")
    return 75e9 * wire.section() / wire.length


def weighed(mass: float, dt: float, coupling: str = "end", **changes: Any) -> MujocoBridge:
    """A mass at rest on an elastic wire."""
    one = actuator(elastic=True, start_force=mass * GRAVITY, **changes)
    return MujocoBridge(hanging(dt, mass), [one], coupling=coupling)


def recurrence(frequency: float, dt: float, weights: ForceWeights, speed: float, steps: int) -> list[float]:
    """Displacements of an oscillator of angular `frequency` [1/s] after a push, step by step.

    MuJoCo's step, v₁ = v₀ + dt a and x₁ = x₀ + dt v₁, under a = -ω²(w₁ x₁ + w₀ x₀ + w₋₁ x₋₁).
    """
    pull, (end, start, before) = (frequency * dt) ** 2, weights
    last, now, found = 0.0, 0.0, [0.0]
    for _ in range(steps):
        after = now + dt * speed - pull * (start * now + before * last)
        last, now = now, after / (1.0 + pull * end)
        speed = (now - last) / dt
        found.append(now)
    return found


def with_lagged_stress(bridge: MujocoBridge, wave: AbstractWaveform, joint: str, steps: int) -> np.ndarray:
    """Positions of a joint if the stress of the step before drives the law in every step.

    The force of the new phase state and the length as it is then acts on the model.
    """
    (strand,), plant, much = bridge.strands, bridge.plant, 1e9
    force, length, found = strand.force, plant.lengths()[0], [bridge.data.joint(joint).qpos[0]]
    for k in range(steps):
        trial = strand.trial(wave.value((k + 0.5) * plant.dt), plant.dt)
        strand.state = trial(force * much, much).state  # whatever the length, this force
        strand.line = length - strand.reference, 0.0
        force = strand.observe(0.0)["force"]
        length = plant.advance([force])[0]
        found.append(bridge.data.joint(joint).qpos[0])
    return np.array(found)


def root_mean_square(values: Any) -> float:
    """Of a sequence."""
    return math.sqrt(float(np.mean(np.square(values))))
