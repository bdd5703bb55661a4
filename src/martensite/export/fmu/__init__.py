"""Export of a scenario as an FMU."""

from __future__ import annotations

from martensite.export.fmu.archive import Fmu, to_fmu

__all__ = ["Fmu", "to_fmu"]
