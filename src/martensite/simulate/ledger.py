r"""Ledgers of heat and work, from the start, middle and end of every step.

Changes of state functions are summed. The work of a force F along a stroke x uses parabolas through start, middle
and end of a step,

∫ F dx = [F₀ (-3 x₀ + 4 x_h - x₁) + 4 F_h (x₁ - x₀) + F₁ (x₀ - 4 x_h + 3 x₁)]/6,

and is exact for a linear relation of force and stroke. Powers are integrated by Simpson's rule. `ledger.c` is
equivalent.

Exchanged energies are also summed as absolute values. They are the work of elements and of the outside, or half of
the changes of stored energy if larger, as in a free oscillation. These sums do not cancel over a cycle.

Heat and work have separate balances and residuals, since the heat balance of a step neglects mechanical work. Heat
is some hundred times larger than work and would dominate a common balance.

Source: Simpson's rule for F dx/dt, textbook.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from operator import itemgetter
from typing import NamedTuple

from martensite.actuators.assembly.ledger import ACCOUNTS, EXCHANGED, HEAT, HELD

SIXTH = 1.0 / 6.0
SIMPSON = (SIXTH, 2.0 * SIXTH, 2.0 * SIXTH, SIXTH)
"""Weights over a step for values at both ends of its halves."""
TURNED_OVER = tuple(ACCOUNTS.index(name) for name in ("work", "outside"))
"""Accounts with work of either sign that counts as exchanged."""
STORES = tuple(1 if name in HEAT else 2 if name in HELD[1:] else 0 for name in ACCOUNTS)
"""Store of every account: 1 for heat, 2 for mechanical energy outside of the elements, else 0."""
LEAST_HEAT = 1e-9
"""Smallest heat [J] that is balanced."""
LEAST_WORK = 1e-12
"""Smallest work [J] that is balanced."""
ROUNDING, NONE = 1e-12, "0 J"
"""Fraction of an energy that counts as zero, and its text."""
RESIDUAL_SHOWN = 1e-12
"""Smallest residual that is shown."""
WORDS = {
    "springs": "stored in springs",
    "gravity": "potential energy",
    "kinetic": "kinetic energy",
    "magnetic": "stored in a winding",
    "dissipated": "dissipated",
    "outside": "delivered to the outside",
}
"""Labels of sinks and stores of work."""


class Book(NamedTuple):
    """Layout of the values of a kernel `entries`: stored energies, efforts in pairs, and a loss."""

    energies: tuple[int, ...] = ()
    """Account of every stored energy, as an index of `ACCOUNTS`."""
    efforts: tuple[int, ...] = ()
    """Account of every effort."""
    has_heat_balance: bool = False
    """True if there is a ledger of the heat."""
    has_work_balance: bool = False
    """True if there is a ledger of the work."""
    unknown: tuple[str, ...] = ()
    """Reasons for missing ledgers, in sentences."""

    @property
    def size(self) -> int:
        """Return the number of values per entry."""
        return len(self.energies) + 2 * len(self.efforts) + self.has_heat_balance


EMPTY = Book()


class Ledger:
    """Accounts of one run [J]."""

    def __init__(self, book: Book, first: Sequence[float]) -> None:
        self.book, self.last = book, first
        self.accounts = [0.0] * len(ACCOUNTS)
        self.lost = 0.0

    def enter(self, middle: Sequence[float], end: Sequence[float], length: float) -> None:
        """Add a step of a length [s] after the previous step."""
        book, rows, given = self.book, (self.last, middle, end), 0.0
        swung = [0.0, 0.0, 0.0]
        for k, account in enumerate(book.energies):
            change = end[k] - self.last[k]
            self.accounts[account] += change
            swung[STORES[account]] += 0.5 * abs(change)
        for k, account in enumerate(book.efforts):
            at = len(book.energies) + 2 * k
            work = integrate_effort([row[at] for row in rows], [row[at + 1] for row in rows])
            self.accounts[account] += work
            if account in TURNED_OVER:
                given += abs(work)
        self.accounts[-2] += swung[1]
        self.accounts[-1] += max(given, swung[2])
        if book.has_heat_balance:
            first, half, last = (row[-1] for row in rows)
            self.lost += SIXTH * length * (first + 4.0 * half + last)
        self.last = end


def integrate_effort(forces: Sequence[float], ways: Sequence[float]) -> float:
    """Return the work [J] of a force along a stroke, known at start, middle and end of a step."""
    (a, b, c), (x, y, z) = forces, ways
    first, middle, last = 4.0 * (y - x) - (z - x), z - x, 3.0 * (z - x) - 4.0 * (y - x)
    return SIXTH * (a * first + 4.0 * b * middle + c * last)


# ---------------------------------------------------------------- balances of a run


@dataclass(frozen=True)
class HeatBalance:
    """Heat balance of a run, over all heated elements, in J."""

    put_in: float
    """Heat from the drives."""
    lost: float
    """Heat loss to ambient."""
    sensible: float
    """Change of sensible heat in the run."""
    latent: float
    """Change of latent heat in the run."""
    exchanged: float = 0.0
    """Half of the absolute changes of both."""

    @property
    def stored(self) -> float:
        """Return the change of sensible and latent heat [J]."""
        return self.sensible + self.latent

    @property
    def residual(self) -> float | None:
        """Return the missing heat as a fraction of the largest of in, lost, stored and exchanged.

        None below `LEAST_HEAT`.
        """
        most = max(abs(self.put_in), abs(self.lost), abs(self.stored), self.exchanged)
        missing = abs(self.put_in - self.lost - self.stored)
        return missing / most if most > LEAST_HEAT else None

    def __str__(self) -> str:
        """Return the balance in one line."""
        most = max(abs(self.put_in), abs(self.lost))
        texts = (_tell_energy(x, most) for x in (self.stored, self.sensible, self.latent))
        stored, sensible, latent = texts
        return (
            f"Heat: {self.put_in:.4g} J input, {self.lost:.4g} J lost to the ambient, "
            f"{stored} stored ({sensible} sensible, {latent} latent); "
            f"{_describe_residual(self.residual)}"
        )

    def as_dict(self) -> dict[str, float | None]:
        """Return all values by name."""
        own = {"put_in": self.put_in, "lost": self.lost, "stored": self.stored}
        more = {"sensible": self.sensible, "latent": self.latent, "exchanged": self.exchanged}
        return own | more | {"residual": self.residual}


@dataclass(frozen=True)
class WorkBalance:
    """Work balance of the elements of a run, in J, with changes of stored energies."""

    work: float
    """Net work of the elements on the mechanism."""
    springs: float
    """Elastic energy of the mechanism: springs, end stops, beams."""
    gravity: float
    kinetic: float
    magnetic: float
    """Magnetic energy of the winding of a motor."""
    dissipated: float
    """Dissipation by damping, friction and the winding of a motor."""
    outside: float
    """Work on prescribed forces, travels or voltages; negative if these drive."""
    exchanged: float
    """Sum of absolute exchanged energies, the reference of the residual."""
    elastic: float | None = None
    """Elastic energy in the elements, outside the balance; None if unknown."""

    @property
    def converted(self) -> float | None:
        """Return the work and elastic energy from transformation and thermal expansion [J]."""
        return None if self.elastic is None else self.work + self.elastic

    @property
    def residual(self) -> float | None:
        """Return the missing work as a fraction of the exchanged work; None if that is zero."""
        storage = self.springs + self.gravity + self.kinetic + self.magnetic
        missing = abs(self.work - storage - self.dissipated - self.outside)
        most = max(self.exchanged, abs(storage), abs(self.dissipated))
        return missing / most if most > LEAST_WORK else None

    def __str__(self) -> str:
        """Return the balance in one line, without zero terms."""
        most = self.exchanged
        texts = {name: _tell_energy(getattr(self, name), most) for name in vars(self)}
        where = [f"{texts[name]} {words}" for name, words in WORDS.items() if texts[name] != NONE]
        within = [] if self.elastic is None else [f"{texts['elastic']} elastic in the elements"]
        parts = ", ".join([f"{texts['work']} done by the elements", *where])
        beside = ", ".join([f"{most:.3g} J exchanged", *within])
        return f"Work: {parts}; {beside}; {_describe_residual(self.residual)}"

    def as_dict(self) -> dict[str, float | None]:
        """Return all values by name."""
        return vars(self) | {"converted": self.converted, "residual": self.residual}


def balance_heat(put_in: float, lost: float, accounts: Sequence[float]) -> HeatBalance:
    """Return the heat balance of a run from heat input, heat loss and accounts [J]."""
    return HeatBalance(put_in, lost, *_read_heat(accounts))


def balance_work(book: Book, accounts: Sequence[float]) -> WorkBalance:
    """Return the work balance of a run from its accounts [J]."""
    elastic = accounts[ELASTIC] if ELASTIC in book.energies else None
    return WorkBalance(*_read_work(accounts), elastic=elastic)


_read_heat = itemgetter(*map(ACCOUNTS.index, ("sensible", "latent", EXCHANGED[0])))
_read_work = itemgetter(*(ACCOUNTS.index(one.name) for one in fields(WorkBalance)[:-1]))
ELASTIC = ACCOUNTS.index("elastic")


def _tell_energy(value: float | None, most: float) -> str:
    """Return an energy [J] in words; empty if it is only rounding of the largest term."""
    return NONE if value is None or not abs(value) > ROUNDING * most else f"{value:.3g} J"


def _describe_residual(residual: float | None) -> str:
    if residual is None:
        return "no energy to balance"
    return f"residual {residual:.1e}" if residual > RESIDUAL_SHOWN else f"residual below {RESIDUAL_SHOWN:.0e}"
