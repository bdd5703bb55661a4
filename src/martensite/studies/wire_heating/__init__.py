"""Study `wire-heating`: electrical heating of a shape-memory wire, Kossoski's thesis, chapter 3."""

from __future__ import annotations

from martensite.studies.base import STUDIES
from martensite.studies.tables import TableStudy


@STUDIES.register("wire-heating")
class WireHeating(TableStudy):
    """Chapter 3 of Kossoski's thesis rebuilt: film coefficient, heat balance, two closures."""
