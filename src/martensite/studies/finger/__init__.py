"""Study `finger`: a robotic finger bent by a shape-memory wire against a spring."""

from __future__ import annotations

from martensite.studies.base import STUDIES
from martensite.studies.tables import TableStudy


@STUDIES.register("finger")
class FingerStudy(TableStudy):
    """The finger rebuilt: heat and law, bending at two powers, a slow loop, other crystals."""
