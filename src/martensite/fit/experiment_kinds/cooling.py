"""Cooling experiment: an element cools without a drive, temperature measured."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from martensite.characterise.loop_paths import LoopPath
from martensite.characterise.time_constant import fit_rise
from martensite.fit.drive_lag import DriveLag
from martensite.fit.experiment_kinds.base import (
    EXPERIMENT_KINDS,
    AbstractExperimentKind,
    Assumptions,
    FitEvidence,
    Proposal,
    RecognisedExperiment,
)
from martensite.fit.experiment_kinds.driven import FILM, ORDER, WIDTH, DrivenElement, describe_element
from martensite.fit.experiment_kinds.loops import keep_measured, reduce_rows
from martensite.fit.experiment_kinds.survey import LogSurvey
from martensite.fit.experiment_kinds.values import make_record
from martensite.scenario.overrides import change_document
from martensite.signals.records import Record

if TYPE_CHECKING:
    from martensite.fit.fit import Fit


@EXPERIMENT_KINDS.register("cooling")
class Cooling(AbstractExperimentKind):
    """Free cooling, without a drive."""

    order = 70.0
    meaning = "left to cool without a drive"
    needs = "a temperature that falls, and times"
    own_zero = True
    given_start = True

    def recognise(self, survey: LogSurvey) -> RecognisedExperiment | None:
        """Return the experiment if the temperature falls, and neither a drive nor a shape varies."""
        if not survey.is_heated or not survey.is_falling or survey.shapes or survey.drives:
            return None
        why = f"only `temperature` varies, over {survey.warming:.0f} K"
        return RecognisedExperiment(self, why, "", ("temperature",))

    def propose(
        self, experiment: RecognisedExperiment, records: Sequence[Record], assumptions: Assumptions
    ) -> Iterator[Proposal]:
        """Yield an element that cools from the start of each record, as if heated until then."""
        rows = [_cut_hot(record) for record in records]
        rises = [fit_rise(one.times.tolist(), one["temperature"].tolist()) for one in rows]
        tau, room = (
            float(np.median([x.value for x in xs])) for xs in zip(*((r.tau, r.final) for r in rises), strict=True)
        )
        effect = "the film coefficient is counted from it; the time constant is not"
        width, length = assumptions.take("element.diameter", "m", WIDTH, effect), 0.1
        c, density = assumptions.take("element.heat_capacity", "J/kg/K", 837.0, effect), 6450.0
        h, hot = density * c * width / (4.0 * tau), max(one["temperature"][0] for one in rows)
        area, fall = math.pi / 4.0 * width**2, max(float(np.ptp(one["temperature"])) for one in rows)
        volts = math.sqrt(h * math.pi * width * length * fall * 9e-7 * length / area)
        document = describe_element("pwm-voltage", (width, length), room, (h, density, c, 0.0))
        lead, span = f"{10.0 * tau:.4g} s", max(one.times[-1] for one in rows)
        document["run"] |= {"lead": lead, "duration": f"{10.0 * tau + span:.4g} s"}
        document["drive"] |= {"supply": f"{volts:.4g} V", "waveform": {"kind": "step", "high": 1, "until": lead}}
        element = DrivenElement(rows, DriveLag(tau, 0.0, room), area, document, ())
        low, high = max(room - fall, 200.0), min(room + 0.5 * fall, hot)
        free = FILM.format(h / 6.0, h * 6.0), f"environment.temperature={low}..{high} K"
        each, column = (f"drive.supply={0.3 * volts:.4g}..{3.0 * volts:.4g} V",), ("temperature",)
        weight = element.take_weight(assumptions)
        yield replace(element.make_proposal("heat alone", weight, free, column), each=each)
        more = ("A_f=30..140 degC", f"latent_heat={0.3 * c:.4g}..{60.0 * c:.4g} J/kg log", *ORDER)
        warm = change_document(document | weight, {"element.latent_heat": f"{10.0 * c:.4g} J/kg"})
        yield replace(element.make_proposal("with transformation", warm, (*free, *more), column), each=each)

    def suggest_records(self, evidence: FitEvidence) -> Iterator[str]:
        """Yield a second fall, and a fall through the transformation."""
        if len(evidence.experiments) < 2:
            yield "A second fall, from another temperature: only a record left out whole shows what is predicted."
        if evidence.proposal == "heat alone":
            yield "A fall through the transformation, if latent heat matters: none was needed here."

    def make_example(self) -> list[Record]:
        """Return a fall by 60 K towards 300 K."""
        return [make_record({"temperature": 300.0 + 60.0 * np.exp(-np.linspace(0.0, 4.0, 80))})]

    def find_time_constant(self, fit: Fit) -> tuple[float, float, float] | None:
        """Return τ = ρ c d/(4 h) [s] with its interval, independent of c and d."""
        values = {leaf.path.rpartition(".")[2]: float(leaf.value) for leaf in fit.system().leaves()}
        film = next(name for name in fit.numbers if name.endswith("cooling.h"))
        low, high = fit.uncertainty.widen_interval(film)
        tau = values["density"] * values["heat_capacity"] * values["diameter"] / (4.0 * fit[film])
        return tau, tau * fit[film] / high, tau * fit[film] / low if low > 0.0 else math.inf


def _cut_hot(record: Record) -> Record:
    """Return a record from the start of cooling, with times from there."""
    cooling = keep_measured(record, ("temperature",))
    kelvin = np.asarray(cooling["temperature"])
    first = int(np.flatnonzero(kelvin >= kelvin.max() - 0.02 * np.ptp(kelvin))[-1])
    times = np.asarray(cooling.times)
    cooling = reduce_rows(cooling, LoopPath(times, (0, len(times) - 1), 0.0, 0), "temperature", first)
    return replace(cooling, columns=cooling.columns | {"time": [t - cooling.times[0] for t in cooling.times]})
