"""Systems: one or several elements on a mechanism."""

from martensite.actuators.assembly.actuator import Actuator, Feed, Group, Members
from martensite.actuators.assembly.base import AbstractSystem, State
from martensite.actuators.assembly.outputs import OUTPUTS, PROFILES
from martensite.actuators.assembly.systems import Machine, System, advance_steps

__all__ = [
    "OUTPUTS",
    "PROFILES",
    "AbstractSystem",
    "Actuator",
    "Feed",
    "Group",
    "Machine",
    "Members",
    "State",
    "System",
    "advance_steps",
]
