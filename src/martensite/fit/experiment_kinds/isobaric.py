"""Isobaric experiment: heating and cooling under constant loads, strain measured."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from martensite.base.errors import DataError, InputError, MartensiteError
from martensite.characterise.isobaric_cycles import find_named_stress
from martensite.characterise.tangent_fit import fit_tangents
from martensite.characterise.tangent_points import find_tangent_points
from martensite.fit.experiment_kinds.base import (
    DIAMETER,
    EXPERIMENT_KINDS,
    LENGTH,
    AbstractExperimentKind,
    Assumptions,
    FitEvidence,
    Proposal,
    RecognisedExperiment,
)
from martensite.fit.experiment_kinds.loops import ROUNDNESS, SLOPES, find_column, read_loop, read_machine, with_law
from martensite.fit.experiment_kinds.survey import DEFORMATIONS, LogSurvey
from martensite.fit.experiment_kinds.values import (
    LAGOUDAS,
    MODULI,
    SLOPE,
    WAIST,
    Document,
    make_loop,
    make_record,
    with_column,
    write_value,
    write_values,
)
from martensite.search.quantity_text import join_phrases
from martensite.signals.records import Record

ZEROED = 0.03
"""Smallest strain over range below which every record seems to have a separate zero."""
CURVES = (
    "curvature_f=-1e-3..1e-3 K/MPa^2",
    "curvature_r=-1e-3..1e-3 K/MPa^2",
    "widening_f=0..0.9 K/MPa",
    "widening_r=0..0.9 K/MPa",
)


@EXPERIMENT_KINDS.register("isobaric")
class Isobaric(AbstractExperimentKind):
    """Loops of temperature under constant loads."""

    order = 50.0
    meaning = "heated and cooled under constant loads"
    needs = "a temperature that varies by more than 15 K and a strain or position"
    axis = "temperature"
    own_zero = True

    def recognise(self, survey: LogSurvey) -> RecognisedExperiment | None:
        """Return the experiment if shape and temperature vary, and no load does."""
        if not survey.shapes or not survey.is_heated or survey.is_loaded:
            return None
        shape = survey.shapes[0]
        why = f"`{shape}` and `temperature` vary, the temperature goes over {survey.warming:.0f} K while the load rests"
        return RecognisedExperiment(self, why, "temperature", (shape,))

    def propose(
        self, experiment: RecognisedExperiment, records: Sequence[Record], assumptions: Assumptions
    ) -> Iterator[Proposal]:
        """Yield laws for loops of temperature under constant loads; the machine prescribes the stress."""
        rows = [_read_loop(record, experiment.measured[0], assumptions) for record in records]
        width = assumptions.settle(DIAMETER, "m", 1e-3)
        section = math.pi / 4.0 * width**2
        loads = sorted(one["stress"][0] for one in rows)
        levels = 1 + int(np.sum(np.diff(loads) > 0.05 * loads[-1]))
        zeroed = len(rows) > 1 and all(min(r["strain"]) < ZEROED * float(np.ptp(r["strain"])) for r in rows)
        if zeroed:
            assumptions.sentences.append(
                "Every record counts strain from its own smallest value: each has a zero of its own."
            )
        size = f'section = "{write_value(section, "m^2")}"'
        names = {"title": "Isobaric loops", "control": "stress", "wide": write_value(width, "m"), "long": "100 mm"}
        base = read_machine(xi=0.0, size=size, **names)
        base["run"]["lead"] = "60 s"
        kelvin = [t for one in rows for t in one["temperature"]]
        if np.mean([one["temperature"][0] for one in rows]) <= 0.5 * (max(kelvin) + min(kelvin)):  # begins cold
            base["drive"]["waveform"]["from"] = write_value(max(kelvin) + 20.0, "K")
        guess = _guess_temperatures(rows)
        if levels == 1:
            guess |= {name: assumptions.take_slope(name, "load") for name in ("C_A", "C_M")}
        elastic = levels > 2 and not zeroed
        moduli = {} if elastic else _take_moduli(assumptions, levels)
        yield from _vary_loop_laws(rows, base, guess | moduli, levels, zeroed or levels == 1)

    def suggest_records(self, evidence: FitEvidence) -> Iterator[str]:
        """Yield further loads."""
        loads = sorted({round(1e-6 * float(np.mean(one.record["stress"]))) for one in evidence.experiments})
        if len(loads) < 3:
            yield (
                f"Loops under other loads than {join_phrases([f'{x:g}' for x in loads])} MPa: three or more tell C_A, "
                "C_M and how the strain grows with stress."
            )
        elif not evidence.predicts or len(loads) < 5:
            gap = max(pairwise(loads), key=lambda pair: pair[1] - pair[0])
            yield f"A loop at {0.5 * sum(gap):.0f} MPa, in the widest gap between the loads."

    def make_example(self) -> list[Record]:
        """Return a loop over 100 K at 100 MPa."""
        loop = make_loop()
        strain = 0.04 * (1.0 - loop**4)
        return [make_record({"temperature": 300.0 + 100.0 * loop, "strain": strain, "stress": 1e8 + 0.0 * loop})]


def _read_loop(record: Record, column: str, assumptions: Assumptions) -> Record:
    """Return the fitted rows of a loop, its strain, and its mean stress [Pa]."""
    column = find_column(record, column, DEFORMATIONS)
    thin = read_loop(record, "temperature", column, assumptions)
    if column != "strain":
        effect = "strain and everything in it is counted from this length"
        strain = np.asarray(thin[column], float) / assumptions.take(LENGTH, "m", 0.1, effect)
        if np.corrcoef(strain, thin["temperature"])[0, 1] > 0.0:
            strain = -strain
            assumptions.sentences.append(f"`{column}` grows on heating, and is taken as shortening.")
        thin = with_column(thin, "strain", "1", strain)
    return with_column(thin, "stress", "Pa", _find_load(record, assumptions))


def _take_moduli(assumptions: Assumptions, levels: int) -> dict[str, float]:
    """Return the given or assumed moduli [Pa], which are equal at one load, where no strain shows their difference."""
    effect = "the transformation strain absorbs the elastic strain of the load"
    austenite = assumptions.take("element.law.E_A", "Pa", MODULI["E_A"], effect)
    return {
        "E_A": austenite,
        "E_M": assumptions.take("element.law.E_M", "Pa", austenite if levels == 1 else 30e9, effect),
    }


def _find_load(record: Record, assumptions: Assumptions) -> float:
    """Return the mean stress of a loop [Pa] from its column, a known section, its name, or an assumed section."""
    if "stress" in record.columns:
        return float(np.nanmean(record["stress"]))
    named = find_named_stress(record)
    if "force" in record.columns and (named is None or assumptions.find_given(DIAMETER) is not None):
        return float(np.nanmean(record["force"])) / (math.pi / 4.0 * assumptions.find_diameter() ** 2)
    if named is not None:
        assumptions.sentences.append(
            f"The name of `{record.name}` is taken to say that its stress was {named / 1e6:g} MPa."
        )
        return named
    raise DataError(
        f"Record `{record.name}` does not say under which stress it was taken: give a column `stress [MPa]` or "
        "`force [N]`, or put it into the name of the file (`wire_100MPa.csv`)."
    )


def _guess_temperatures(rows: Sequence[Record]) -> dict[str, float]:
    """Return law parameters from tangents, or otherwise from the middles of the strokes."""
    points: list[Any] = []
    for one in rows:
        try:
            points.append(find_tangent_points(one, stress=one["stress"][0]))
        except MartensiteError:
            continue
    try:
        guess = fit_tangents(points).guess("cosine")
    except InputError:
        one, middle, apart = rows[-1], float(np.mean(rows[-1]["temperature"])), 8.0
        if points:
            middle, apart = (
                0.5 * (points[-1].A_half + points[-1].M_half),
                0.5 * abs(points[-1].A_half - points[-1].M_half),
            )
        zero = middle - one["stress"][0] / SLOPE
        guess = {"A_s": zero + apart - 7.0, "A_f": zero + apart + 7.0, "M_s": zero - apart + 7.0}
        guess |= {"M_f": zero - apart - 7.0, "eps_L": float(np.ptp(one["strain"]))}
    return guess if {"C_A", "C_M"} <= set(guess) else {"C_A": SLOPE, "C_M": SLOPE} | guess


def _vary_loop_laws(
    rows: Sequence[Record], base: Document, guess: Mapping[str, float], levels: int, zeroed: bool
) -> Iterator[Proposal]:
    """Yield Liang–Rogers, then Lagoudas: with a waist, with four exponents, and with curved surfaces.

    If moduli have no visible effect, at one or two loads or with separate zeros, the guess contains given or assumed
    moduli. At three loads and more they are free.
    """
    stroke = max(float(np.ptp(one["strain"])) for one in rows)
    sigma = max(float(np.mean([one["stress"][0] for one in rows])), 1e6)
    top, apart = guess["A_f"] + 10.0, max(guess["A_f"] - guess["M_s"], 3.0)
    wide = max(guess["A_f"] - guess["A_s"], 4.0), max(guess["M_s"] - guess["M_f"], 4.0)
    shared = write_values("Pa", E_A=guess.get("E_A", MODULI["E_A"]), E_M=guess.get("E_M", 30e9))
    shared |= write_values("Pa/K", C_A=guess["C_A"], C_M=guess["C_M"])
    common = SLOPES if levels > 1 else ()
    common += ("E_A=15..200 GPa", "E_M=5..150 GPa") if "E_A" not in guess else ()

    def build_proposal(name: str, law: Document, free: Sequence[str], widen: float) -> Proposal:
        above, below = (widen * w for w in wide)
        low = top - apart - max(below, above - apart + 5.0)
        places = write_values("K", A_f=top, A_s=top - above, M_s=top - apart, M_f=low)
        temperatures = ("A_f", "A_s-A_f=-400..-1 K", "M_s-A_f=-200..-0.5 K", "M_f-M_s=-400..-1 K")
        again = {"A_s-A_f": -2.0 * above, "M_f-M_s": -2.0 * max(below, above)}
        document = with_law(base, shared | places | law)
        each = ("offset.strain",) if zeroed else ()
        return Proposal(name, document, (*temperatures, *common, *free), ("strain",), rows, each, (again,))

    kelvin = [t for one in rows for t in (min(one["temperature"]), max(one["temperature"]))]
    surface = LAGOUDAS | {"alpha_A": "1e-5 1/K", "alpha_M": "6e-6 1/K", "sigma_cal": write_value(sigma, "Pa")}
    surface |= write_values("K", T_ref=guess["A_f"])
    if levels > 2:
        surface |= {"H_min": 0.3 * stroke, "H_sat": 0.8 * stroke, "H_k": f"{1e6 / sigma:.4g} 1/MPa"}
        strain = ("H_min=0..0.15", "H_sat=0.002..0.19", "H_k=1e-3..0.1 1/MPa")
    else:
        surface |= {"H_min": stroke, "H_sat": 0.19, "H_k": "0 1/MPa"}
        strain = ("H_min=0.001..0.15",)
    strain += ("alpha_A=-2e-5..4e-5 1/K", "alpha_M=-2e-5..4e-5 1/K")
    strain += () if zeroed else (f"T_ref={min(kelvin):.5g}..{max(kelvin):.5g} K",)
    simple = {"kind": "liang-rogers", "eps_L": 0.8 * stroke, "modulus": "mixture", "Theta": "0 Pa/K"}
    yield build_proposal("liang-rogers", simple, ("eps_L=0.001..0.19",), 1.0)
    waist = {"hardening": "waisted", "waist_f": 0.8, "waist_r": 0.8, "n_1": 0.4, "n_2": 0.5, "n_3": 0.4, "n_4": 0.5}
    yield build_proposal("lagoudas with a waist", surface | waist, (*strain, *WAIST), 2.0)
    yield build_proposal("lagoudas", surface, (*strain, *ROUNDNESS), 1.3)
    if levels > 2:
        curved = surface | waist | {"surfaces": "curved", "widening_f": "0.05 K/MPa", "widening_r": "0.05 K/MPa"}
        yield build_proposal("lagoudas with a waist and curved surfaces", curved, (*strain, *WAIST, *CURVES), 1.0)
