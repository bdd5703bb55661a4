"""A published finger prototype, its geometry completed for this project, and how it is heated.

The element is both half wires as one of twice the length; zero of the angle is the cold finger
with all martensite oriented. Every law with the numbers of the prototype can be built in.
"""

from __future__ import annotations

from typing import Any

from martensite.actuators.assembly import System
from martensite.actuators.elements.wire import Wire
from martensite.actuators.mechanisms.finger import Finger
from martensite.physics.electrical.resistances import FurstSeeleckeResistance
from martensite.physics.electrical.sources import PowerSource
from martensite.physics.laws.base import LAWS
from martensite.physics.materials.base import load_material
from martensite.physics.thermal.base import Environment
from martensite.physics.thermal.films import ConstantCooling
from martensite.signals.table import Table

NUMBERS = {name: number.value for name, number in load_material("finger-mas").values.items()}
DURATION = 25.0  # [s]


def finger_law(name: str = "mas", **changes: Any) -> Any:
    """A law with the numbers of the prototype; keyword arguments replace some."""
    cls: Any = LAWS[name]
    known = {key: NUMBERS[key] for key in cls.declarations if key in NUMBERS}
    return cls(**(known | changes))


def joint(offset: float = 3.5e-3, arm: float = 8e-3, **changes: Any) -> Finger:
    """Its mechanism with r and a [m]; keyword arguments replace other numbers and options."""
    sizes: dict[str, Any] = {"bracket": 10.6e-3, "stiffness": 50.0, "extension": 1e-3}
    return Finger(offset=offset, arm=arm, **(sizes | changes))


def finger(law: Any = None, offset: float = 3.5e-3, arm: float = 8e-3, **changes: Any) -> System:
    """The prototype with a law, r and a [m], and changes of its mechanism."""
    resistance = {key: NUMBERS[key] for key in FurstSeeleckeResistance.declarations if key in NUMBERS}
    wire = Wire(
        diameter=0.1e-3,
        length=0.44,
        density=NUMBERS["density"],
        heat_capacity=NUMBERS["heat_capacity"],
        latent_heat=NUMBERS["latent_heat"],
        law=law or finger_law(),
        resistance=FurstSeeleckeResistance(**resistance),
    )
    return System(
        element=wire,
        source=PowerSource(),
        environment=Environment(temperature=295.0, cooling=ConstantCooling(h=200.0)),
        mechanism=joint(offset, arm, **changes),
    )


def trapezoid(watts: float = 2.0) -> Table:
    """Power [W] into both halves: zero until 3 s, full from 5 s to 13 s, zero from 15 s on."""
    times = (0.0, 3.0, 5.0, 13.0, 15.0, DURATION)
    return Table(times=times, values=(0.0, 0.0, watts, watts, 0.0, 0.0))
