"""Constrained recovery: stress over temperature at fixed length, without a drive.

A stretched element that is heated at fixed length pulls: the stress rises along the reverse transformation,
dσ/dT = C_A, until the strain is recovered elastically. On cooling it falls along the forward transformation.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from martensite.fit.experiment_kinds.base import (
    EXPERIMENT_KINDS,
    LENGTH,
    AbstractExperimentKind,
    Assumptions,
    FitEvidence,
    Proposal,
    RecognisedExperiment,
)
from martensite.fit.experiment_kinds.loops import SLOPES, find_column, read_loop, read_machine, with_law
from martensite.fit.experiment_kinds.survey import LOADS, LogSurvey
from martensite.fit.experiment_kinds.values import EPS, make_loop, make_record, with_column, write_values
from martensite.signals.records import Record

STIFF = 60e9
"""Assumed modulus of austenite [Pa]; martensite has half of it."""


@EXPERIMENT_KINDS.register("recovery")
class ConstrainedRecovery(AbstractExperimentKind):
    """A stretched element, heated and cooled at fixed length."""

    order = 65.0
    meaning = "stretched, then heated and cooled at fixed length"
    needs = "a temperature that varies by more than 15 K, and a stress or force that varies"
    axis = "temperature"

    def recognise(self, survey: LogSurvey) -> RecognisedExperiment | None:
        """Return the experiment if temperature and load vary, and neither a drive nor a shape does."""
        if survey.drives or survey.shapes or not survey.is_heated or not survey.is_loaded:
            return None
        load = survey.loads[0]
        why = f"`{load}` varies over {survey.warming:.0f} K while no shape and no drive varies"
        return RecognisedExperiment(self, why, "temperature", (load,))

    def propose(
        self, experiment: RecognisedExperiment, records: Sequence[Record], assumptions: Assumptions
    ) -> Iterator[Proposal]:
        """Yield Liang–Rogers at constant elongation, from martensite, with the first stress as preload."""
        rows = [_read_recovery(one, experiment.measured[0], assumptions) for one in records]
        eps = assumptions.take("element.law.eps_L", "1", EPS, "the width of the transformation is counted from it")
        first = max(float(np.mean([one["stress"][0] for one in rows])), 1e6)
        effect = "the width of the transformation is counted from it"
        stiff, soft = (
            assumptions.take(f"element.law.{n}", "Pa", x, effect) for n, x in (("E_A", STIFF), ("E_M", 0.5 * STIFF))
        )
        begins, apart = (float(np.mean(x)) for x in zip(*map(_find_begins, rows), strict=True))
        width = assumptions.settle("element.diameter", "m", 1e-3)
        size = f'preload = "{first * math.pi / 4.0 * width**2:.6g} N"'
        names = write_values("m", wide=width, long=assumptions.settle(LENGTH, "m", 0.1))
        base = read_machine(title="Constrained recovery", control="elongation", xi=1.0, size=size, **names)
        base["signals"] = {"command": {"kind": "constant", "level": "0 mm"}}
        slope = min(max(float(np.mean([_find_slope(one) for one in rows])), 3e6), 25e6)
        places = {"A_s": begins - first / slope, "A_f": begins - first / slope + 25.0}
        places |= {"M_s": places["A_f"] - max(apart, 5.0), "M_f": places["A_s"] - max(apart, 5.0)}
        law = {"kind": "liang-rogers", "modulus": "mixture", "eps_L": eps, "Theta": "0 Pa/K"}
        law |= write_values("K", **places) | write_values("Pa", E_A=stiff, E_M=soft)
        law |= write_values("Pa/K", C_A=slope, C_M=slope)
        free = ("A_s=-50..150 degC", "A_f-A_s=1..150 K", "M_s-A_f=-100..-0.5 K", "M_f-M_s=-150..-1 K", *SLOPES)
        yield Proposal("liang-rogers", with_law(base, law), free, ("stress",), rows)

    def suggest_records(self, evidence: FitEvidence) -> Iterator[str]:
        """Yield another prestrain, and a free recovery."""
        yield "A free recovery (strain over temperature) and moduli: at fixed length only a part transforms."

    def make_example(self) -> list[Record]:
        """Return a stress that rises on heating and falls at lower temperatures on cooling."""
        loop = make_loop()
        late = np.where(np.arange(len(loop)) < len(loop) // 2, 0.4, 0.2)
        stress = 4e8 * np.clip((loop - late) / 0.5, 0.05, 1.0)
        return [make_record({"temperature": 290.0 + 100.0 * loop, "stress": stress})]


def _read_recovery(record: Record, load: str, assumptions: Assumptions) -> Record:
    """Return the fitted rows of a recovery with its stress [Pa]."""
    load = find_column(record, load, LOADS)
    rows = read_loop(record, "temperature", load, assumptions)
    if load == "force":
        section = math.pi / 4.0 * assumptions.find_diameter() ** 2
        rows = with_column(rows, "stress", "Pa", np.asarray(rows["force"]) / section)
    return rows


def _find_begins(one: Record) -> tuple[float, float]:
    """Return the temperature at which the stress begins to rise [K], and the width of the loop half-way up [K]."""
    kelvin, stress = np.asarray(one["temperature"]), np.asarray(one["stress"])
    hot = int(np.argmax(kelvin))
    share = (stress - stress.min()) / max(float(np.ptp(stress)), 1e-30)

    def cross(part: slice, level: float) -> float:
        order = np.argsort(kelvin[part])
        above = np.flatnonzero(share[part][order] > level)
        return float(kelvin[part][order][above[0]]) if above.size else float(kelvin[0])

    up, down = slice(0, hot + 1), slice(hot, len(kelvin))
    return cross(up, 0.05), cross(up, 0.5) - cross(down, 0.5)


def _find_slope(one: Record) -> float:
    """Return the slope of the stress half-way up on heating [Pa/K]."""
    kelvin, stress = np.asarray(one["temperature"]), np.asarray(one["stress"])
    hot = int(np.argmax(kelvin)) + 1
    low, high = stress.min() + 0.25 * np.ptp(stress), stress.min() + 0.75 * np.ptp(stress)
    part = np.flatnonzero((stress[:hot] > low) & (stress[:hot] < high))
    return float(np.polyfit(kelvin[part], stress[part], 1)[0]) if part.size > 2 else 7.5e6
