"""Study `platform`: a parallel platform turned about two axes by shape-memory springs."""

from __future__ import annotations

from martensite.studies.base import STUDIES
from martensite.studies.tables import TableStudy


@STUDIES.register("platform")
class Platform(TableStudy):
    """The parallel platform rebuilt: kinematics, stroke, response times, ON/OFF control."""
