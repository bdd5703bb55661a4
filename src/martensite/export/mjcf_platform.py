"""Parallel platform as MJCF: a plate on two hinges, and a straight tendon at each vertex.

The frame of `martensite.actuators.mechanics.platform_kinematics` has Z down; here z is up, so its points (X, Y, Z) are
at (X, -Y, -Z). The hinge `beta` turns about -y and carries `alpha` about x, which makes R_Y(β) R_X(α). Plate and joint
are exact: mass, moments of inertia I, I and 2 I at the centroid, its height over the joint, gravity, damping. The drawn
shapes have no effect on the mechanism.
"""

from __future__ import annotations

from xml.etree.ElementTree import Element

from martensite.actuators.mechanics.platform_kinematics import locate_corners
from martensite.actuators.mechanisms.parallel_platform import ParallelPlatform
from martensite.export.mjcf_model import BLUE, DARK, GREY, Model, add_element, append_element
from martensite.kernels import floats


def write_platform(model: Model, platform: ParallelPlatform, timestep: float) -> None:
    """Add the platform to a model."""
    joint, above = platform.height - platform.eccentricity, platform.eccentricity
    side, plate = platform.side, platform.top_plate(floats)
    model.option.set("gravity", f"0 0 {-float(platform.gravity)!r}")
    far = max(side, platform.height)
    append_element(
        model.world,
        "camera",
        name="view",
        pos=(1.9 * far, -2.6 * far, 0.5 * platform.height + 1.2 * far),
        xyaxes="0.807 0.590 0 -0.206 0.282 0.937",
        fovy="25",
    )
    _add_mesh(model, side)
    append_element(model.world, "geom", type="mesh", mesh="plate", rgba=GREY)
    append_element(model.world, "geom", type="capsule", fromto=(0, 0, 0, 0, 0, joint), size=0.02 * side, rgba=GREY)
    body = append_element(model.world, "body", name="plate", pos=(0.0, 0.0, joint))
    for name, axis in (("beta", "0 -1 0"), ("alpha", "1 0 0")):
        append_element(body, "joint", name=name, axis=axis, damping=platform.damping)
    moments = (plate.inertia, plate.inertia, 2.0 * plate.inertia)
    append_element(body, "inertial", pos=(0.0, 0.0, above), mass=plate.mass, diaginertia=moments)
    append_element(body, "geom", type="sphere", size=0.035 * side, rgba=DARK)
    append_element(body, "geom", type="mesh", mesh="plate", pos=(0.0, 0.0, above), rgba=BLUE)
    _add_vertices(model.world, "base", side, 0.0)
    _add_vertices(body, "top", side, above)
    starts = zip(platform.ports(), platform.start_forces(floats), strict=True)
    for i, (port, force) in enumerate(starts):
        add_element(model, port, (f"base{i}", f"top{i}"), force)


def _add_vertices(parent: Element, name: str, side: float, height: float) -> None:
    for i, (x, y) in enumerate(locate_corners(side)):
        append_element(parent, "site", name=f"{name}{i}", pos=(x, -y, height), size=0.012 * side)


def _add_mesh(model: Model, side: float) -> None:
    half = 0.008 * side
    points = [v for z in (-half, half) for x, y in locate_corners(side) for v in (x, -y, z)]
    append_element(model.asset, "mesh", name="plate", vertex=points)
