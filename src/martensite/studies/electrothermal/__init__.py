"""Study `electrothermal-staircase`: resistance of a Flexinol wire against current."""

from __future__ import annotations

from martensite.studies.base import STUDIES
from martensite.studies.tables import TableStudy


@STUDIES.register("electrothermal-staircase")
class ElectrothermalStaircase(TableStudy):
    """Resistance against current of a Flexinol wire under a staircase of voltage.

    The record is not part of the package. Without it the claims that need it are `not
    checkable`, and the figure shows the model alone; both say how to fetch it.
    """
