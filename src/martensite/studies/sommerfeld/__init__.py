"""Study `sommerfeld`: a motor on a beam, and a wire against it, Kossoski's thesis."""

from __future__ import annotations

from martensite.studies.base import STUDIES
from martensite.studies.tables import TableStudy


@STUDIES.register("sommerfeld")
class Sommerfeld(TableStudy):
    """Chapters 4 and 5 of Kossoski's thesis rebuilt: the Sommerfeld effect, and a hot wire."""
