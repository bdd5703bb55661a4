"""MJCF lines of the elements of a system, to paste into another MuJoCo model.

Each element needs a tendon through sites; `MujocoActuators` adds the actuator. The document can also be included by
MuJoCo's `<include file="..."/>`; its sites are in a comment, since they belong to bodies. For a mechanism with a writer
in `martensite.export.mjcf`, sites and paths are those of its model; for any other, the reader places two sites per
element.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple
from xml.etree.ElementTree import Element, indent, tostring

from martensite.actuators.assembly import AbstractSystem
from martensite.actuators.mechanisms.base import AbstractMechanism
from martensite.actuators.mechanisms.finger import Finger
from martensite.actuators.mechanisms.parallel_platform import ParallelPlatform
from martensite.base.errors import InputError
from martensite.export.mjcf import WRITERS, model_of, start_forces
from martensite.export.mjcf_model import ORANGE, append_element

FRAMES: dict[type[AbstractMechanism], str] = {
    Finger: "The origin is on the hinge, which turns about +y; the phalanges lie along -x and +x, "
    "the\n   wire is below them.",
    ParallelPlatform: "The origin is in the middle of the base, z is up; that of the plate is on the joint.",
}
"""Description of the frame of the sites, by mechanism."""
ANYWHERE = (
    "Every element needs one where it is held and one where it pulls: `pos` and names are\n"
    "   yours. What counts is how the path between them changes, not how long it is."
)


class Parts(NamedTuple):
    """Parts of a snippet."""

    sites: list[tuple[str, Element]]
    """Name of the body and element of each site."""
    tendons: list[Element]
    where: str
    """Description of the frame."""


def to_mjcf_snippet(system: AbstractSystem) -> str:
    """Return the tendons of the elements of a system as MJCF, with sites and advice in a comment.

    Args:
        system: a `System` or a `Machine`.

    Raises:
        InputError: it has no elements, or its mechanism has a feature that MuJoCo lacks.
    """
    if not system.actuators():
        raise InputError(f"There is no shape-memory element in {system.description()}.")
    parts = _list_sites_and_paths(system) if type(system.mechanism) in WRITERS else _left_open(system)
    root = Element("mujocoinclude")
    append_element(root, "tendon").extend(parts.tendons)
    indent(root)
    comment = COMMENT.format(
        where=parts.where,
        sites="\n".join(_write_sites(parts.sites)),
        forces="\n".join(f"   {port}: {F:.6g} N" for port, F in start_forces(system).items()),
    )
    return f"<!--{comment.replace('--', '- -')}-->\n{tostring(root, encoding='unicode')}\n"


def _list_sites_and_paths(system: AbstractSystem) -> Parts:
    model, ports = model_of(system), set(system.actuators())
    tendons = [one for one in model.tendons if one.get("name") in ports]
    used = {site.get("site") for one in tendons for site in one}
    places = [("<worldbody>", model.world)]
    places += [(f'<body name="{one.get("name")}">', one) for one in model.world.iter("body")]
    sites = [(place, site) for place, body in places for site in body.findall("site") if site.get("name") in used]
    return Parts(sites, tendons, FRAMES.get(type(system.mechanism), ""))


def _left_open(system: AbstractSystem) -> Parts:
    sites: list[tuple[str, Element]] = []
    tendons = [Element("spatial", name=port, width="0.0006", rgba=ORANGE) for port in system.actuators()]
    for end, body in (("holder", "the body that holds one end"), ("pulled", "the body it pulls")):
        for tendon in tendons:
            name = f"{tendon.get('name')}_{end}"
            sites.append((body, Element("site", name=name, pos="0 0 0", size="0.001")))
            append_element(tendon, "site", site=name)
    return Parts(sites, tendons, ANYWHERE)


def _write_sites(sites: list[tuple[str, Element]]) -> Iterator[str]:
    before = ""
    for place, site in sites:
        if place != before:
            yield f"   in {place}:"
        before = place
        yield f"     {tostring(site, encoding='unicode')}"


COMMENT = """
Shape-memory elements for a MuJoCo model of your own. Written by martensite; SI units.

1. Sites. Paste each line into its body; `pos` is in the frame of that body.
   {where}
{sites}

2. Tendons. Paste the section below, or write <include file="..."/> with the name of
   this file. A path may have more sites, or bend over a cylinder: <geom geom="drum"/>. An element
   that goes to and fro n times needs <pulley divisor="1/n"/> (as a number) before its sites.
   Give the tendon no actuator and no stiffness: martensite.export.MujocoActuators adds the element.

3. Flags. Geoms that overlap at a joint collide if one of them belongs to the world; where nothing
   is to touch: <option><flag contact="disable"/></option>

4. Start. The element has to be told how hard it is pulled where the model starts. On the
   mechanism of the scenario:
{forces}
   martensite.export.holding_tensions finds the tensions that hold your model still. Weights, springs and stops
   of that mechanism are not here: your model takes its place.
"""
