"""Stroke experiment: a drive moves the load of an element."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from martensite.fit.experiment_kinds.base import EXPERIMENT_KINDS, Assumptions, Proposal, RecognisedExperiment
from martensite.fit.experiment_kinds.driven import AbstractDrivenKind, assume_law, start_driven, vary_loads
from martensite.fit.experiment_kinds.survey import DEFORMATIONS, LogSurvey
from martensite.fit.experiment_kinds.values import EPS, SIGMA, Document, make_pulses, make_record
from martensite.search.quantity_text import format_number
from martensite.signals.records import Record


@EXPERIMENT_KINDS.register("stroke")
class StrokeTest(AbstractDrivenKind):
    """A weight or a bias spring that a driven element moves."""

    order = 10.0
    meaning = "a drive moves what the element carries"
    needs = "a drive (voltage, current, power or duty) and a position, or strain, that vary"
    answers = DEFORMATIONS
    shows_shape = True

    def list_further(self, survey: LogSurvey) -> list[str]:
        """Return the varying loads."""
        return survey.loads

    def propose_driven(
        self, experiment: RecognisedExperiment, records: Sequence[Record], assumptions: Assumptions
    ) -> Iterator[Proposal]:
        """Yield a weight and a bias spring; the spring alone if force and position are measured."""
        column = experiment.measured[0]
        output = "strain" if column == "strain" else "position"
        stroke = max(float(np.nanmax(r[column]) - np.nanmin(r[column])) for r in records)
        guess = (0.1, "without effect on strain"), (stroke / (0.8 * EPS), "the transformation strain absorbs it")
        length = assumptions.take("element.length", "m", *guess[output == "position"])
        element = assume_law(
            start_driven(experiment, records, assumptions, length), assumptions, ("A_f", "C_A", "C_M", "E_A", "E_M")
        )
        up = (element.lag.gain > 0.0) == (output == "position")
        if not up:
            assumptions.sentences.append(f"`{column}` falls with the drive: its sign is turned.")
        columns = [output if up and column == output else f"{output}={column}*{1 if up else -1}"]
        free, force = (*element.free, f"eps_L={EPS / 6.0:.4g}..0.19"), SIGMA * element.section
        if len(experiment.measured) > 1:
            spring, more = _read_spring(experiment, records, element.section, assumptions)
            columns.append(experiment.measured[1])
            yield element.make_proposal("a bias spring", {"mechanism": spring}, (*free, *more), columns, output)
            return
        travel = stroke if output == "position" else 0.03 * length
        for name, mechanism, more in vary_loads(assumptions, force, travel):
            yield element.make_proposal(name, {"mechanism": mechanism}, (*free, *more), columns, output)

    def make_example(self) -> list[Record]:
        """Return pulses of the duty cycle, and a position that follows them."""
        pulses = make_pulses()
        return [make_record({"duty": pulses, "position": 0.004 * np.roll(pulses, 3)})]


def _read_spring(
    kind: RecognisedExperiment, records: Sequence[Record], section: float, assumptions: Assumptions
) -> tuple[Document, tuple[str, str]]:
    """Return a spring with rate and preload from measured force and position, and their bounds."""
    column, load = kind.measured
    x, f = (np.concatenate([np.asarray(r[name], float) for r in records]) for name in (column, load))
    f, good = f * (section if load == "stress" else 1.0), np.isfinite(x) & np.isfinite(f)
    slope, zero = (float(v) for v in np.polyfit(x[good], f[good], 1))
    rate, least = max(abs(slope), 1e-3), max(float(np.nanmin(f)), 1e-3)
    assumptions.sentences.append(
        f"`{load}` over `{column}` is a spring of {format_number(rate)} N/m, and {format_number(zero)} N at zero."
    )
    spring = {"kind": "bias-spring", "stiffness": f"{rate:.5g} N/m", "preload": f"{least:.5g} N"}
    bounds = f"stiffness={0.5 * rate:.5g}..{2.0 * rate:.5g} N/m", f"preload={0.2 * least:.5g}..{5.0 * least:.5g} N"
    return spring, bounds
