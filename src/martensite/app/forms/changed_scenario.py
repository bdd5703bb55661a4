"""A document with another kind in it, and what is to be said about it."""

from __future__ import annotations

from dataclasses import dataclass, field

from martensite.app.forms.table_filler import MissingNumber
from martensite.app.messages import JsonTable


@dataclass
class ChangedScenario:
    """A document with another kind in it."""

    document: JsonTable
    notes: list[str] = field(default_factory=list[str])
    assumed: list[str] = field(default_factory=list[str])
    """Paths of start values."""
    missing: list[MissingNumber] = field(default_factory=list[MissingNumber])
