"""Study `migaone`: shape memory alloy modelling and simulation on a MigaOne-15 actuator."""

from __future__ import annotations

from martensite.scenario.examples import EXAMPLES
from martensite.studies.base import STUDIES
from martensite.studies.tables import TableStudy


@STUDIES.register("migaone")
class MigaOne(TableStudy):
    """The MigaOne-15 paper rebuilt: geometry, h(T), steady states, sine response, speed."""

    scenario_files = (str(EXAMPLES / "migaone.toml"),)
