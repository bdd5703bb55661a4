"""Finger as MJCF: one hinge, a tendon through sites at (∓g, -r), and a return spring.

The model has the equation of `martensite.actuators.mechanisms.finger`:

    wire              2 |g cos θ/2 - r sin θ/2| between the sites, n times by a pulley of divisor
                      1/n: the path that the bowstring shortens by n ΔL
    follower spring   stiffness k a² of the hinge with its zero at -δ₀/a: k a (δ₀ + a θ)
    fixed spring      a tendon of stiffness k and rest length H - δ₀
    inertia, damping  of the hinge; the centre of mass is on it

End stops, and brackets that meet at 2 φ, are limits of the joint; if there are two on one side, only the nearer. Their
static stiffness is K of the mechanism. They are critically damped with a time constant t of two steps, whereas the
mechanism bounces. With MuJoCo's impedance d, a limit that is exceeded by x has the torque

    I s x/(1 - d),        hence s = K (1 - d)/I,        d = 1/(1 + I/(K t²)).

With `contact`, stops have no declared stiffness. Stops and the cylinder are as stiff as MuJoCo allows at this time
step. Cylinder and phalanx are capsules that collide without friction. The mass is at its centre, with the remaining
inertia about it.

Beyond the angle where the brackets meet, the path grows again; during contact both models agree to about a degree only.
MuJoCo evaluates the damping b at the end of a step, as if the inertia were b Δt/2 larger.

The phalanges lie along ∓x, the wire below them; θ grows as it pulls and turns about +y. The drawn shapes have no effect
on the mechanism.
"""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element

from martensite.actuators.mechanisms.finger import Finger
from martensite.base.errors import InputError
from martensite.export.mjcf_model import BLUE, DARK, GREY, Model, Value, add_element, append_element, write_attribute
from martensite.kernels import floats

SETTLES = 2.0
"""Time constant of a limit or contact, in steps: the minimum of MuJoCo."""
HARD = (0.9999, 0.9999, 1e-3)
"""Impedance of rigid contacts: the maximum of MuJoCo."""


def write_finger(model: Model, finger: Finger, timestep: float) -> None:
    """Write the finger."""
    _check_finger(finger)
    r, g = finger.offset, finger.bracket
    (port,), (start,) = finger.ports(), finger.start_forces(floats)
    append_element(
        model.world, "camera", name="view", pos=(0.2 * g, -20.0 * g, -1.3 * g), xyaxes="1 0 0 0 0 1", fovy="20"
    )
    _add_phalanx(model.world, finger, -1.0, GREY)
    append_element(model.world, "site", name="near", pos=(-g, 0.0, -r), size=0.1 * r)
    body = append_element(model.world, "body", name="phalanx")
    append_element(body, "joint", **_describe_joint(finger, timestep))
    _add_inertia(model, body, finger)
    append_element(body, "geom", type="cylinder", size=(0.5 * r, 0.6 * r), euler=(0.5 * math.pi, 0, 0), rgba=DARK)
    _add_phalanx(body, finger, 1.0, BLUE)
    append_element(body, "site", name="far", pos=(g, 0.0, -r), size=0.1 * r)
    if finger.contact == "cylinder":
        _add_contact(model.world, body, finger, SETTLES * timestep)
    add_element(model, port, ("near", "far"), start, finger.passes)
    if finger.spring == "fixed":
        _fixed_spring(model, body, finger)


def _check_finger(finger: Finger) -> None:
    if finger.friction > 0.0:
        raise InputError(
            "Tendons of MuJoCo slide without friction, but parameter `friction` of `finger` is "
            f"{finger.friction:.4g}; set it to 0."
        )
    if finger.spring == "fixed" and finger.extension > finger.height:
        raise InputError(
            f"Parameter `extension` of `finger` must be at most `height`, {1e3 * finger.height:.6g} mm, but is "
            f"{1e3 * finger.extension:.6g} mm: no spring of MuJoCo is shorter at rest than nothing."
        )


def _describe_joint(finger: Finger, timestep: float) -> dict[str, Value]:
    attributes: dict[str, Value] = {"name": "angle", "axis": "0 1 0", "damping": finger.damping}
    if finger.spring == "follower":
        attributes["stiffness"] = finger.stiffness * finger.arm**2
        attributes["springref"] = -finger.extension / finger.arm
    if finger.stop > 0.0 or finger.contact != "springs":
        attributes |= _describe_limits(finger, SETTLES * timestep)
    return attributes


def _describe_limits(finger: Finger, settles: float) -> dict[str, Value]:
    """Return range and compliance of the hinge limits, which settle in `settles` [s]."""
    met = 2.0 * math.atan2(finger.bracket, finger.offset)
    reach = (finger.lowest, min(finger.highest, met))
    if finger.contact != "springs":
        return {"limited": "true", "range": reach, "solreflimit": (settles, 1.0), "solimplimit": HARD}
    impedance = 1.0 / (1.0 + finger.inertia / (finger.stop * settles**2))
    stiffness = finger.stop * (1.0 - impedance) / finger.inertia
    return {
        "limited": "true",
        "range": reach,
        "solreflimit": (-stiffness, -2.0 * impedance / settles),
        "solimplimit": (impedance, impedance, 1e-3),
    }


def _add_inertia(model: Model, body: Element, finger: Finger) -> None:
    """Add the inertia about the hinge; with a weight, as a mass at its centre and the remainder."""
    if finger.weight == "none":
        append_element(body, "inertial", pos="0 0 0", mass="0.001", diaginertia=[finger.inertia] * 3)
        return
    centre = finger.centre * finger.phalanx_length
    rest = finger.inertia - finger.mass * centre**2
    if rest <= 0.0:
        raise InputError(
            f"Parameter `inertia` of `finger` must be above that of its mass at its centre, "
            f"{finger.inertia - rest:.4g} kg m^2, but is {finger.inertia:.4g} kg m^2: nothing is left about the centre."
        )
    append_element(body, "inertial", pos=(centre, 0.0, 0.0), mass=finger.mass, diaginertia=[rest] * 3)
    pull = finger.gravity * math.cos(finger.tilt), 0.0, -finger.gravity * math.sin(finger.tilt)
    model.option.set("gravity", write_attribute(pull))


def _add_contact(world: Element, body: Element, finger: Finger, settles: float) -> None:
    """Add a cylinder across the plane, and the far phalanx that collides with it."""
    hard: dict[str, Value] = {"contype": "1", "conaffinity": "1", "condim": "1"}
    hard |= {"solref": (settles, 1.0), "solimp": HARD, "type": "capsule"}
    x, z, half = finger.cylinder_along, -finger.cylinder_inwards, 4.0 * finger.cylinder_radius
    ends = (x, -half, z, x, half, z)
    append_element(world, "geom", name="cylinder", fromto=ends, size=finger.cylinder_radius, rgba=GREY, **hard)
    phalanx = (0.0, 0.0, 0.0, finger.phalanx_length, 0.0, 0.0)
    append_element(body, "geom", name="touching", fromto=phalanx, size=0.5 * finger.thickness, rgba=BLUE, **hard)


def _fixed_spring(model: Model, body: Element, finger: Finger) -> None:
    """Add a spring from the phalanx at a to a fixed point at (a, H)."""
    append_element(model.world, "site", name="anchor", pos=(finger.arm, 0.0, finger.height), size="0.0005")
    append_element(body, "site", name="arm", pos=(finger.arm, 0.0, 0.0), size="0.0005")
    rest = finger.height - finger.extension
    spring = append_element(
        model.tendons,
        "spatial",
        name="spring",
        stiffness=finger.stiffness,
        springlength=rest,
        width="0.0004",
        rgba=DARK,
    )
    append_element(spring, "site", site="anchor")
    append_element(spring, "site", site="arm")


def _add_phalanx(parent: Element, finger: Finger, side: float, colour: str) -> None:
    r, g = finger.offset, finger.bracket
    append_element(
        parent, "geom", type="box", size=(1.9 * g, 0.6 * r, 0.3 * r), pos=(2.1 * side * g, 0, 0), rgba=colour
    )
    append_element(
        parent, "geom", type="box", size=(0.1 * r, 0.6 * r, 0.55 * r), pos=(side * g, 0.0, -0.55 * r), rgba=colour
    )
