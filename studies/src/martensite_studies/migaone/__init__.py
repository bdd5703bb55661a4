"""Study `migaone`: shape memory alloy modelling and simulation on a MigaOne-15 actuator."""

from __future__ import annotations

from martensite_studies.migaone.study import MigaOne

__all__ = ["MigaOne"]
