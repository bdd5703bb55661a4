"""What the tests of sections of fibres share: a bar on a given elongation or force, closed forms of plateaus."""

from __future__ import annotations

from typing import Any

from builders import ZERO, example, example_environment, law_a

from martensite.actuators.elements.arms import BendingBeam, TorsionWire
from martensite.actuators.elements.base import Heating, Spring
from martensite.kernels import floats
from martensite.physics.electrical.sources import PrescribedTemperature
from martensite.physics.laws.coupling import StepReport

WARM = 90 + ZERO
BARS: dict[str, tuple[type[Any], dict[str, Any]]] = {
    "wire": (TorsionWire, {}),
    "tube": (TorsionWire, {"inner_diameter": 0.6e-3}),
    "bent ribbon": (BendingBeam, {"shape": "ribbon"}),
    "bent wire": (BendingBeam, {"shape": "wire"}),
    "bent tube": (BendingBeam, {"shape": "tube", "inner_diameter": 0.6e-3}),
}
"""Class and choices of every section."""


def bar(name: str, **changes: Any) -> Any:
    """A bar of 1 mm whose arm of 1 m makes an angle and a moment; austenite of problem A if no law is given."""
    cls, choices = BARS[name]
    usual = {"law": law_a(Theta=0.0), "initial_fraction": 0.0, "diameter": 1e-3, "arm": 1.0, "length": 0.1}
    return example(cls, **(usual | choices | changes))


def flat_law(width: float = 2e-3) -> Any:
    """A stress plateau at constant temperature: strips as good as lines, one Young's modulus."""
    return law_a(modulus="austenite", Theta=0.0, M_s=325.15, M_f=325.15 - width, A_s=341.15, A_f=341.15 + width)


def step(element: Any, state: Any, pull: Any, temperature: float = WARM) -> tuple[Any, StepReport]:
    """One step at a temperature, against a mechanism."""
    heating = Heating(example_environment(), PrescribedTemperature(), temperature)
    return element.advance(floats, state, heating, pull, 1.0)


def held_at(elongation: float) -> Any:
    """A mechanism that gives an elongation [m]."""

    def pull(_: Any, spring: Spring) -> float:
        return (elongation - spring.free) / spring.compliance

    return pull


def moment_at(element: Any, elongations: list[float], temperature: float = WARM) -> list[float]:
    """Forces on the way through elongations, from rest."""
    state, found = element.init(floats, 0.0, temperature), []
    for e in elongations:
        state, report = step(element, state, held_at(e), temperature)
        assert report.residual <= 1e-8
        found.append(state.force)
    return found


def plateau_torque(shear: float) -> float:
    """Torque of a round bar per torque at the onset of a plateau, at a shear per that of the onset."""
    return shear if shear < 1.0 else 4.0 / 3.0 * (1.0 - 0.25 / shear**3)


def plateau_moment(curvature: float) -> float:
    """Moment of a ribbon, likewise."""
    return curvature if curvature < 1.0 else 1.5 * (1.0 - 1.0 / (3.0 * curvature**2))
