r"""The ledgers of a march: what is entered at the ends and in the middle of every step.

Functions of the state are entered as they change. The work of a force F along a way x is that of
the parabolas through start, middle and end of a step,

    ∫ F dx = [F₀ (-3 x₀ + 4 x_h - x₁) + 4 F_h (x₁ - x₀) + F₁ (x₀ - 4 x_h + 3 x₁)]/6,

exact for any two of them, and so for every straight line between force and way. A power is
integrated by Simpson's rule. `ledger.c` does the same.

Source: Simpson's rule for F dx/dt, textbook.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from martensite.actuators.assembly.ledger import ACCOUNTS, EXCHANGED

SIXTH = 1.0 / 6.0
TURNED_OVER = tuple(ACCOUNTS.index(name) for name in ("work", "outside"))
"""Accounts whose work, whichever way it goes, is what is exchanged."""


class Book(NamedTuple):
    """What a kernel `entries` returns: energies that are held, efforts in pairs, and a loss."""

    held: tuple[int, ...] = ()
    """Account of every energy, by its place in `ACCOUNTS`."""
    efforts: tuple[int, ...] = ()
    """Account of every effort."""
    heat: bool = False
    """Whether there is a ledger of the heat."""
    work: bool = False
    """Whether there is one of the work."""
    unknown: tuple[str, ...] = ()
    """Why there is none, in sentences."""

    @property
    def size(self) -> int:
        """Numbers that are entered at a time."""
        return len(self.held) + 2 * len(self.efforts) + self.heat


EMPTY = Book()


class Ledger:
    """The accounts of one run [J]."""

    def __init__(self, book: Book, first: Sequence[float]) -> None:
        self.book, self.last = book, first
        self.accounts = [0.0] * len(ACCOUNTS)
        self.lost = 0.0

    def enter(self, middle: Sequence[float], end: Sequence[float], length: float) -> None:
        """A step of a length [s], from where the last one ended."""
        book, rows = self.book, (self.last, middle, end)
        for k, account in enumerate(book.held):
            self.accounts[account] += end[k] - self.last[k]
        for k, account in enumerate(book.efforts):
            at = len(book.held) + 2 * k
            work = integrate_effort([row[at] for row in rows], [row[at + 1] for row in rows])
            self.accounts[account] += work
            if account in TURNED_OVER:
                self.accounts[ACCOUNTS.index(EXCHANGED)] += abs(work)
        if book.heat:
            first, half, last = (row[-1] for row in rows)
            self.lost += SIXTH * length * (first + 4.0 * half + last)
        self.last = end


def integrate_effort(forces: Sequence[float], ways: Sequence[float]) -> float:
    """Work [J] of a force along a way, known at start, middle and end of a step."""
    (a, b, c), (x, y, z) = forces, ways
    first, middle, last = 4.0 * (y - x) - (z - x), z - x, 3.0 * (z - x) - 4.0 * (y - x)
    return SIXTH * (a * first + 4.0 * b * middle + c * last)
