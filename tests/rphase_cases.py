"""A wire with an R-phase, and the wire that somebody takes it for who knows of none."""

from __future__ import annotations

from typing import Any, TypeVar

from builders import problem_a, wire_a

from martensite.actuators.assembly import System
from martensite.actuators.mechanisms.load_line import BiasSpring
from martensite.base.parameters import Parametrised
from martensite.physics.electrical.resistances import FurstSeeleckeResistance, ThreePhaseResistance
from martensite.physics.electrical.switches import PwmVoltage
from martensite.physics.laws.base import AbstractLaw
from martensite.physics.laws.r_phase import RPhase
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.physics.materials.base import load_material

Some = TypeVar("Some", bound=Parametrised)
VALUES = {name: number.value for name, number in load_material("niti-r-phase").values.items()}


def of_material(cls: type[Some], **choices: Any) -> Some:
    """A part with numbers of the material that has an R-phase."""
    return cls(**({name: VALUES[name] for name in cls.declarations if name in VALUES} | choices))


def rphase_law(history: str = "resume", **changed: float) -> RPhase:
    return of_material(RPhase, history=history, **changed)


def rphase_system(law: AbstractLaw | None = None, **parts: Any) -> System:
    """The wire against a soft spring, with a resistance of three phases, driven by PWM."""
    size = {"heat_capacity": VALUES["heat_capacity"], "latent_heat": VALUES["latent_heat"]}
    wire = wire_a(law or rphase_law(), **size).with_parts(resistance=of_material(ThreePhaseResistance))
    usual: dict[str, Any] = {
        "element": wire,
        "source": PwmVoltage(supply=6.0),
        "mechanism": BiasSpring(stiffness=500, preload=5),
    }
    return problem_a(**(usual | parts))


def two_phase_model() -> System:
    """The same wire to somebody who knows of no R-phase; every number that both have is the same."""
    system = rphase_system(of_material(LiangRogers, modulus="mixture"))
    two = of_material(FurstSeeleckeResistance)
    return system.with_parts(element=system.element.with_parts(resistance=two))
