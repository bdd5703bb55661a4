"""Systems: one element, or several, on a mechanism."""

from __future__ import annotations

from martensite.actuators.assembly.actuator import Actuator, Feed, Group
from martensite.actuators.assembly.base import AbstractSystem, State
from martensite.actuators.assembly.course import advance_steps
from martensite.actuators.assembly.machine import Machine
from martensite.actuators.assembly.members import Members
from martensite.actuators.assembly.outputs import OUTPUTS, PROFILES
from martensite.actuators.assembly.single import System

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
