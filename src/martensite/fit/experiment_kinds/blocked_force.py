"""Blocked-force experiment: a drive makes a force at constant length."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from martensite.fit.experiment_kinds.base import EXPERIMENT_KINDS, Assumptions, Proposal, RecognisedExperiment
from martensite.fit.experiment_kinds.driven import ABSORBED, WIDTH, AbstractDrivenKind, assume_law, start_driven
from martensite.fit.experiment_kinds.survey import LOADS
from martensite.fit.experiment_kinds.values import make_pulses, make_record
from martensite.signals.records import Record


@EXPERIMENT_KINDS.register("blocked-force")
class BlockedForce(AbstractDrivenKind):
    """A driven element between two grips."""

    order = 20.0
    meaning = "a drive makes a force at constant length"
    needs = "a drive and a force that vary"
    answers = LOADS
    shows_shape = True

    def propose_driven(
        self, experiment: RecognisedExperiment, records: Sequence[Record], assumptions: Assumptions
    ) -> Iterator[Proposal]:
        """Yield a driven element between two rigid grips."""
        column = experiment.measured[0]
        most, least = (float(f([f(r[column]) for r in records])) for f in (np.nanmax, np.nanmin))
        length = assumptions.take("element.length", "m", 0.1, "without effect on a force")
        wide = math.sqrt(4.0 * max(most, 1e-4) / (math.pi * 250e6))
        guess = (wide, f"at it the largest force is 250 MPa; {ABSORBED}") if column == "force" else (WIDTH, ABSORBED)
        element = assume_law(start_driven(experiment, records, assumptions, length, guess), assumptions, ("A_f",))
        preload = max(least * (1.0 if column == "force" else element.section), 1e-4)
        machine = {"kind": "testing-machine", "control": "elongation", "preload": f"{preload:.5g} N"}
        document = {"mechanism": machine, "signals": {"command": {"kind": "constant", "level": "0 mm"}}}
        more = ("E_A=5..250 GPa", "E_M=2..200 GPa", "C_A=1..40 MPa/K", "C_M=1..40 MPa/K")
        yield element.make_proposal("fixed ends", document, (*element.free, *more), (column,), column)

    def make_example(self) -> list[Record]:
        """Return pulses of the voltage, and a force that follows them at a constant position."""
        pulses = make_pulses()
        force = 5.0 + np.roll(pulses, 3)
        return [make_record({"voltage": 3.0 * pulses, "force": force, "position": 0.0 * pulses})]
