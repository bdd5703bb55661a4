"""Study `wire-heating`: electrical heating of a shape-memory wire, Kossoski's thesis, chapter 3."""

from __future__ import annotations

from martensite_studies.wire_heating.study import WireHeating

__all__ = ["WireHeating"]
