"""What `size` prints: the candidates, one of them in words, the check of the catalogue."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from martensite.cli import show

if TYPE_CHECKING:
    from martensite.design.sizing.candidates import Sizing
    from martensite.design.sizing.catalogue_check import CheckRow

NEAREST = 5
"""Wires that do not do and are shown if none does."""


# ---------------------------------------------------------------- candidates


def show_candidates(sizing: Sizing, every: bool, chosen: int | None) -> None:
    """Print the table of wires: those that do, or all, or the nearest."""
    from martensite.show.reports.sizing import COLUMNS, row

    right = ",".join(COLUMNS[:1] + COLUMNS[4:-1])
    numbered = list(enumerate(sizing.candidates))
    good = [(i, found) for i, found in numbered if found.feasible]
    shown = numbered if every else good or numbered[:NEAREST]
    if chosen is not None and chosen not in [i for i, _ in shown]:
        shown.append(numbered[chosen])
    show.table(COLUMNS, [row(i + 1, found) for i, found in shown], right=right)
    for i, found in shown:
        if not found.feasible:
            show.text(f"{i + 1} does not: {found.reasons[0]}.")
    left = len(numbered) - len(shown)
    if not good:
        show.text("No wire meets the request; the nearest come first.", "yellow")
    if left:
        show.text(f"{left} more do not do; --all shows them with the reason.")


def show_one(sizing: Sizing, chosen: int) -> None:
    """Print one candidate in words."""
    from martensite.show.reports import sizing as words

    found = sizing.candidates[chosen]
    show.text(words.headline(found), "bold")
    for line in words.sentences(sizing.request, found):
        show.text(line)
    for reason in found.reasons:
        show.text(f"Not met: {reason}.", "red")
    for warning in found.warnings:
        show.text(f"Warning: {warning}.", "yellow")
    for line in words.doubts(found):
        show.text(line, "yellow")


# ---------------------------------------------------------------- the check of the catalogue


def show_check(rows: Sequence[CheckRow], stress: float, ambient: float) -> None:
    """Print the model beside the maker's table."""
    from martensite.show.reports import catalogue_check as words

    show.text(words.conditions(stress, ambient))
    right = ",".join(words.COLUMNS[2:])
    show.table(words.COLUMNS, [words.cells(row) for row in rows], right=right)
    for line in words.spread_sentences(rows):
        show.text(line)
    show.text(words.DOUBT, "yellow")
