"""Systems: one element, or several, on a mechanism."""

from __future__ import annotations

from martensite.system.actuator import Actuator, Feed, Group
from martensite.system.base import AbstractSystem, State
from martensite.system.course import advanced
from martensite.system.machine import Machine
from martensite.system.members import Members
from martensite.system.outputs import OUTPUTS, PROFILES, Outputs
from martensite.system.single import System

__all__ = [
    "OUTPUTS",
    "PROFILES",
    "AbstractSystem",
    "Actuator",
    "Feed",
    "Group",
    "Machine",
    "Members",
    "Outputs",
    "State",
    "System",
    "advanced",
]
