"""Study `electrothermal-staircase`: resistance of a Flexinol wire against current."""

from __future__ import annotations

from martensite_studies.electrothermal.study import ElectrothermalStaircase

__all__ = ["ElectrothermalStaircase"]
