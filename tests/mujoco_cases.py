"""MuJoCo models and elements along their tendons."""

from __future__ import annotations

from typing import Any

from builders import hanging_wire

from martensite.actuators.elements.wire import Wire
from martensite.export.mujoco_actuators import COUPLINGS, MujocoActuators, TendonActuator
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling

GRAVITY = 9.81

HANGING = """<mujoco>
<option timestep="{dt}" gravity="0 0 -9.81"/>
<worldbody><site name="top" pos="0 0 1"/>
  <body pos="0 0 0.7"><joint name="x" type="slide" axis="0 0 1"/>
    <geom type="sphere" size="0.01" mass="{mass}"/><site name="bottom"/></body></worldbody>
<tendon><spatial name="wire"><site site="top"/><site site="bottom"/></spatial></tendon>
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


def weighed(mass: float, dt: float, coupling: str = "end", **changes: Any) -> MujocoActuators:
    """A mass at rest on an elastic wire."""
    one = actuator(elastic=True, start_force=mass * GRAVITY, **changes)
    return MujocoActuators(hanging(dt, mass), [one], coupling=coupling)


def recurrence(frequency: float, dt: float, speed: float, steps: int, coupling: str = "end") -> list[float]:
    """Displacements of an oscillator of angular `frequency` [1/s] after a push, step by step.

    MuJoCo's step, v₁ = v₀ + dt a and x₁ = x₀ + dt v₁, under a = -ω²(w₁ x₁ + w₀ x₀ + w₋₁ x₋₁).
    """
    pull, (end, start, before) = (frequency * dt) ** 2, COUPLINGS[coupling]
    last, now, positions = 0.0, 0.0, [0.0]
    for _ in range(steps):
        after = (now + dt * speed - pull * (start * now + before * last)) / (1.0 + pull * end)
        speed, last, now = (after - now) / dt, now, after
        positions.append(now)
    return positions
