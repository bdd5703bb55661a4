"""DSC experiment: heat flow of a small sample over temperature, evaluated without a scenario by `fit dsc`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from martensite.base.errors import DataError
from martensite.characterise.heat_ramps import has_heat_flow
from martensite.fit.experiment_kinds.base import (
    EXPERIMENT_KINDS,
    AbstractExperimentKind,
    Assumptions,
    FitEvidence,
    Proposal,
    RecognisedExperiment,
)
from martensite.fit.experiment_kinds.survey import LogSurvey
from martensite.fit.experiment_kinds.values import make_loop, make_record
from martensite.signals.records import Record


@EXPERIMENT_KINDS.register("dsc")
class DifferentialCalorimetry(AbstractExperimentKind):
    """Heating and cooling of a sample in a calorimeter."""

    order = 5.0
    meaning = "heated and cooled in a calorimeter (DSC)"
    needs = "a heat flow and a temperature that varies by more than 20 K"
    command = "dsc"

    def recognise(self, survey: LogSurvey) -> RecognisedExperiment | None:
        """Return the experiment if a heat flow is recorded over a varying temperature."""
        if not survey.is_heated or survey.shapes or not all(map(has_heat_flow, survey.records)):
            return None
        why = f"a heat flow is recorded while `temperature` goes over {survey.warming:.0f} K"
        return RecognisedExperiment(self, why, "", ("temperature",))

    def propose(
        self, experiment: RecognisedExperiment, records: Sequence[Record], assumptions: Assumptions
    ) -> Iterator[Proposal]:
        """Raise `DataError`: no scenario is needed."""
        raise DataError(
            f"These logs are a `dsc` experiment, {self.meaning}: `martensite fit dsc FILE` computes A_s, A_f, M_s, M_f "
            "and the latent heat."
        )

    def suggest_records(self, evidence: FitEvidence) -> Iterator[str]:
        """Yield ramps of another rate."""
        yield "Ramps of half and twice the rate: their extrapolation to rate 0 removes the lag of the sample."

    def make_example(self) -> list[Record]:
        """Return a heating and a cooling with one peak each."""
        loop = make_loop()
        kelvin = 280.0 + 100.0 * loop
        up = np.arange(len(loop)) < len(loop) // 2
        heat = np.where(up, 1.0, -1.0) * np.exp(-(((kelvin - np.where(up, 340.0, 320.0)) / 8.0) ** 2))
        return [make_record({"temperature": kelvin, "heat_flow": 200.0 * heat})]
