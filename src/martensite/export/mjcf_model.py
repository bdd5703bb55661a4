"""An MJCF document under construction, for the writers of mechanisms.

Numbers are written to the last digit; angles in rad, all else in SI. Geoms are for display: they do not collide, and
bodies have explicit inertia.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from martensite.kernels.namespace import Scalar

Value = str | Scalar | Sequence[Scalar]
GREY, BLUE, DARK, ORANGE = "0.6 0.64 0.67 1", "0.12 0.37 0.55 1", "0.3 0.35 0.4 1", "0.84 0.37 0 1"
HEADER = (
    " Written by martensite. SI units, angles in rad. martensite.export.MujocoActuators puts the "
    "elements along the tendons; custom/numeric holds the force of each element at assembly [N]. "
)


class Model(NamedTuple):
    """Sections of a document."""

    root: Element
    option: Element
    asset: Element
    world: Element
    tendons: Element
    starts: Element

    def text(self) -> str:
        """Return the document."""
        indent(self.root)
        return f"<!--{HEADER}-->\n{tostring(self.root, encoding='unicode')}\n"


def new_model(name: str, timestep: float) -> Model:
    """Return a document without bodies, gravity and tendons."""
    root = Element("mujoco", model=name)
    append_element(root, "compiler", angle="radian")
    option = append_element(root, "option", timestep=timestep, gravity=(0.0, 0.0, 0.0))
    visual = append_element(root, "visual")
    append_element(visual, "headlight", ambient="0.5 0.5 0.5")
    append_element(visual, "map", znear="0.01")
    asset = append_element(root, "asset")
    append_element(asset, "texture", type="skybox", builtin="flat", rgb1="1 1 1", rgb2="1 1 1", width="8", height="8")
    append_element(append_element(root, "default"), "geom", contype="0", conaffinity="0", mass="0")
    sections = ("worldbody", "tendon", "custom")
    return Model(root, option, asset, *(append_element(root, name) for name in sections))


def append_element(parent: Element, tag: str, **attributes: Value) -> Element:
    """Return a new child element with attributes."""
    return SubElement(parent, tag, {name: write_attribute(value) for name, value in attributes.items()})


def add_element(model: Model, port: str, sites: Sequence[str], start_force: Scalar, passes: Scalar = 1.0) -> None:
    """Add a tendon through sites for the shape-memory element at a port.

    With `passes` n a pulley in front of the sites multiplies lengths and moment arms by n: an element that goes back
    and forth has n strands in series.
    """
    tendon = append_element(model.tendons, "spatial", name=port, width=6e-4, rgba=ORANGE)
    if passes != 1.0:
        append_element(tendon, "pulley", divisor=1.0 / passes)
    for site in sites:
        append_element(tendon, "site", site=site)
    append_element(model.starts, "numeric", name=f"start_force_{port}", data=start_force)


def write_attribute(value: Value) -> str:
    """Return an attribute: text unchanged, numbers to the last digit."""
    if isinstance(value, str):
        return value
    if isinstance(value, Sequence):
        return " ".join(write_attribute(one) for one in value)
    return repr(float(value))
