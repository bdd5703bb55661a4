"""Resistance experiment: a drive heats an element whose resistance is measured."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from martensite.fit.experiment_kinds.base import EXPERIMENT_KINDS, Assumptions, Proposal, RecognisedExperiment
from martensite.fit.experiment_kinds.driven import AbstractDrivenKind, assume_law, start_driven
from martensite.fit.experiment_kinds.survey import DRIVES, LogSurvey
from martensite.fit.experiment_kinds.values import make_pulses, make_record
from martensite.signals.records import Record


@EXPERIMENT_KINDS.register("resistance")
class Resistance(AbstractDrivenKind):
    """Driven element under a constant load, with measured resistance."""

    order = 40.0
    meaning = "a drive heats an element whose resistance is measured"
    needs = "a drive and a resistance that vary"
    answers = ("resistance",)

    def recognise(self, survey: LogSurvey) -> RecognisedExperiment | None:
        """Return the experiment if a drive and a resistance vary, or both voltage and current do."""
        experiment = super().recognise(survey)
        if experiment is not None or not survey.drives:
            return experiment
        drive = survey.drives[0]
        rest = [name for name in survey.list_varying(DRIVES) if name != drive and name in ("voltage", "current")]
        if not rest:
            return None
        why = f"`{drive}` drives, and `{rest[0]}` answers through the resistance"
        return RecognisedExperiment(self, why, drive, (rest[0],))

    def propose_driven(
        self, experiment: RecognisedExperiment, records: Sequence[Record], assumptions: Assumptions
    ) -> Iterator[Proposal]:
        """Yield an element with start values of the resistivities, measured or computed from voltage and current."""
        length = assumptions.take("element.length", "m", 0.1, "resistivities absorb it")
        element, column = (
            assume_law(start_driven(experiment, records, assumptions, length), assumptions, ("A_f",)),
            experiment.measured[0],
        )
        if column == "resistance":
            ohms = [float(f([f(r[column]) for r in records])) for f in (np.nanmin, np.nanmax)]
        else:
            pairs = [
                np.asarray(r["voltage"]) / np.where(np.abs(r["current"]) > 0.0, r["current"], np.nan) for r in records
            ]
            ohms = [float(np.nanpercentile(np.concatenate(pairs), q)) for q in (5.0, 95.0)]
        rho = {name: x * element.section / length for name, x in zip(("rho_A", "rho_M"), ohms, strict=True)}
        mixture = {"kind": "mixture"} | {name: f"{x:.5g} ohm*m" for name, x in rho.items()}
        document = {"element": element.document["element"] | {"resistance": mixture}} | element.take_weight(assumptions)
        more = tuple(f"{name}={0.3 * x:.5g}..{3.0 * x:.5g} ohm*m" for name, x in rho.items())
        yield element.make_proposal("under a weight", document, (*element.free, *more), (column,))

    def make_example(self) -> list[Record]:
        """Return pulses of the current, and a resistance that follows them."""
        pulses = make_pulses()
        return [make_record({"current": pulses, "resistance": 4.0 - 0.3 * np.roll(pulses, 3)})]
