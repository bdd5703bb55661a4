"""Study `electrothermal-staircase`: resistance of a Flexinol wire against current."""

from __future__ import annotations

from martensite.studies.base import STUDIES
from martensite.studies.tables import TableStudy


@STUDIES.register("electrothermal-staircase")
class ElectrothermalStaircase(TableStudy):
    """Resistance against current of a Flexinol wire under a staircase of voltage.

    Without the record, which is not part of the package, its claims are not comparable and the figure shows the model
    alone.
    """
