"""A mechanism of tests: what a host integrates outside of an FMU, as a run of our own has it inside."""

from typing import Any

from martensite.actuators.mechanisms.multibody import AbstractMultibody, Coordinate
from martensite.base.parameters import Number, param


class Slider(AbstractMultibody):
    """m x'' + c x' + k x + F₀ = F: a mass on a spring and a damper, drawn by an element."""

    mass: Number = param("kg", "mass", above=0.0)
    damping: Number = param("N*s/m", "damping", low=0.0)
    stiffness: Number = param("N/m", "spring rate", low=0.0)
    preload: Number = param("N", "force at home", low=0.0)

    def coordinates(self) -> tuple[Coordinate, ...]:
        return (Coordinate("position", "m", "position of the mass", "x", 1e-6),)

    def contraction(self, xp: Any, position: Any) -> Any:
        return position

    def start_forces(self, xp: Any) -> Any:
        return [self.preload]

    def demand(self, xp: Any, motion: Any, signals: Any) -> Any:
        (x,), (v,), (a,) = motion
        return [self.preload + self.stiffness * x + self.damping * v + self.mass * a]
