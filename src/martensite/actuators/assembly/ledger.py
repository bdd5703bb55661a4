"""Energy accounts of a system in a state: the heat, and the mechanical energy.

There are two balances, because the heat balance of an element excludes mechanical work:

    heat    input of the drives = losses + change of (sensible + latent)
    work    of the elements = change of (springs + gravity + kinetic + magnetic)
                            + dissipated + given to the outside

Some accounts are functions of the state. The others are work along a path or losses, which the time integration adds
up.
"""

from dataclasses import dataclass, field

from martensite.actuators.elements.base import Effort
from martensite.kernels.namespace import Scalar

HEAT = ("sensible", "latent")
"""Accounts of heat in elements."""
HELD = ("elastic", "springs", "gravity", "kinetic", "magnetic")
"""Accounts of stored mechanical energy; elements store the elastic energy."""
FLOWING = ("work", "dissipated", "outside")
"""Accounts of work: of elements, of resistance, and against the outside."""
EXCHANGED = ("exchanged_heat", "exchanged")
"""Accounts of exchanged heat and work in absolute terms, the scales of the residuals."""
ACCOUNTS: tuple[str, ...] = (*HEAT, *HELD, *FLOWING, *EXCHANGED)


@dataclass
class Entries:
    """Energy accounts of a state; a missing account is empty."""

    energies: dict[str, Scalar] = field(default_factory=dict[str, Scalar])
    """Account -> energy [J] as a function of the state, up to a constant."""
    efforts: list[tuple[str, Effort]] = field(default_factory=list[tuple[str, Effort]])
    """Account and effort along a path."""
    lost: Scalar = 0.0
    """Heat loss [W] of elements of known heat."""
    has_heat_balance: bool = False
    """True if there is a heat balance."""
    has_work_balance: bool = False
    """True if there is a work balance."""
    unknown: tuple[str, ...] = ()
    """Reasons for missing balances, in sentences."""
