"""A scenario as an FMU: one module per part of the archive."""

from __future__ import annotations

from martensite.export.fmu.archive import Fmu, to_fmu

__all__ = ["Fmu", "to_fmu"]
