"""Heating experiment: a drive heats an element with measured temperature."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from martensite.fit.experiment_kinds.base import EXPERIMENT_KINDS, Assumptions, Proposal, RecognisedExperiment
from martensite.fit.experiment_kinds.driven import AbstractDrivenKind, start_driven
from martensite.fit.experiment_kinds.values import make_pulses, make_record
from martensite.scenario.overrides import change_document
from martensite.signals.records import Record


@EXPERIMENT_KINDS.register("heating")
class ElectricHeating(AbstractDrivenKind):
    """Driven element under a constant load, with measured temperature."""

    order = 30.0
    meaning = "a drive heats an element whose temperature is measured"
    needs = "a drive and a temperature that vary"
    answers = ("temperature",)

    def propose_driven(
        self, experiment: RecognisedExperiment, records: Sequence[Record], assumptions: Assumptions
    ) -> Iterator[Proposal]:
        """Yield an element that transforms, and one that is heated only."""
        length = assumptions.take("element.length", "m", 0.1, "film coefficient and heat capacity absorb it")
        element, column = start_driven(experiment, records, assumptions, length), "temperature"
        weight = element.take_weight(assumptions)
        yield element.make_proposal(
            "with transformation", weight, ("A_f=30..140 degC", *element.free), (column,), column
        )
        plain = change_document(element.document | weight, {"element.latent_heat": "0 J/kg"})
        yield element.make_proposal("heat alone", plain, element.free[:2], (column,), column)

    def make_example(self) -> list[Record]:
        """Return pulses of the current, and a temperature that follows them."""
        pulses = make_pulses()
        return [make_record({"current": pulses, "temperature": 300.0 + 60.0 * np.roll(pulses, 3)})]
