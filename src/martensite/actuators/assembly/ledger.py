"""Energy accounts of a system in a state: the heat, and the mechanical energy.

Two ledgers, since the heat balance of an element leaves mechanical work out:

    heat    what drives put in = lost + change of (sensible + latent)
    work    of the elements = change of (springs + gravity + kinetic + magnetic)
                            + dissipated + given to the outside

Some of it is a function of the state. The rest is the work of a force along a way, which whoever
marches adds up, as it does the losses, which are a power.
"""

from dataclasses import dataclass, field

from martensite.actuators.elements.base import Effort
from martensite.kernels.namespace import Scalar

HEAT = ("sensible", "latent")
"""Accounts of the heat that elements hold."""
HELD = ("elastic", "springs", "gravity", "kinetic", "magnetic")
"""Accounts of mechanical energy that is held; the elastic one by the elements."""
FLOWING = ("work", "dissipated", "outside")
"""Accounts of work: of the elements, of what resists, and against the outside."""
EXCHANGED = ("exchanged_heat", "exchanged")
"""Accounts of heat and of work that changed places, whichever way it went: the scales of the residuals."""
ACCOUNTS: tuple[str, ...] = (*HEAT, *HELD, *FLOWING, *EXCHANGED)


@dataclass
class Entries:
    """Energy accounts of a state; a missing account is empty."""

    held: dict[str, Scalar] = field(default_factory=dict[str, Scalar])
    """Energies [J] that are functions of the state, but for constants, by account."""
    efforts: list[tuple[str, Effort]] = field(default_factory=list[tuple[str, Effort]])
    """Efforts along ways, with their accounts."""
    lost: Scalar = 0.0
    """Power [W] that elements whose heat is known lose to the surroundings."""
    heat: bool = False
    """True if there is a ledger of the heat."""
    work: bool = False
    """True if there is a ledger of the work."""
    unknown: tuple[str, ...] = ()
    """Why there is none, in sentences."""
