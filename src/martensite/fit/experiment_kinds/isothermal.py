"""Isothermal experiment: loading and unloading at constant temperature, stress measured."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from martensite.base import units
from martensite.characterise.loop_paths import trace_loop
from martensite.fit.experiment_kinds.base import (
    EXPERIMENT_KINDS,
    AbstractExperimentKind,
    Assumptions,
    FitEvidence,
    Proposal,
    RecognisedExperiment,
)
from martensite.fit.experiment_kinds.loops import ROUNDNESS, SLOPES, find_column, read_loop, read_machine, with_law
from martensite.fit.experiment_kinds.survey import DEFORMATIONS, LOADS, LogSurvey
from martensite.fit.experiment_kinds.values import (
    ROOM,
    SLOPE,
    Document,
    make_loop,
    make_record,
    with_column,
    write_value,
    write_values,
)
from martensite.search.quantity_text import list_names
from martensite.signals.records import Record

CELSIUS = re.compile(r"(-?\d+(?:[.,]\d+)?)[ _]?(?:deg ?|°)?C\b")
TEMPERATURE_WORDS = ("temp", "chamber", "ofen", "kammer")
"""Words, or parts of words, for the temperature of a test in the lines above a table."""
NARROW = 4.0
"""Half the assumed width of a transformation [K]."""
ELASTIC = 0.05, 0.4
"""Stress range of elastic first loading, relative to the plateau stress."""


@EXPERIMENT_KINDS.register("isothermal")
class Isothermal(AbstractExperimentKind):
    """Loops of strain at constant temperatures."""

    order = 60.0
    meaning = "drawn and released at a constant temperature"
    needs = "strain and stress (or elongation and force) that vary"
    axis = "strain"
    own_zero = True

    def recognise(self, survey: LogSurvey) -> RecognisedExperiment | None:
        """Return the experiment if a shape and a load vary."""
        if not survey.shapes or not survey.is_loaded:
            return None
        shape, load = survey.shapes[0], survey.loads[0]
        why = f"{list_names([shape, load])} vary, no drive varies"
        why += "" if survey.is_heated else ", nor does the temperature"
        return RecognisedExperiment(self, why, shape, (load, shape))

    def propose(
        self, experiment: RecognisedExperiment, records: Sequence[Record], assumptions: Assumptions
    ) -> Iterator[Proposal]:
        """Yield laws for loops of strain at constant temperatures; the machine prescribes the strain."""
        load, shape = experiment.measured
        rows = [_read_test(one, load, shape, assumptions) for one in records]
        if len({round(one["temperature"][0]) for one in rows}) < 2:
            _ = [assumptions.take_slope(name, "temperature") for name in ("C_A", "C_M")]
        length, width = (
            assumptions.settle("element.length", "m", 0.1),
            assumptions.settle("element.diameter", "m", 1e-3),
        )
        size, names = f'gauge_length = "{write_value(length, "m")}"', write_values("m", wide=width, long=length)
        title, xi = "Loops at constant temperature", float(_stays_drawn(rows))
        base = read_machine(title=title, control="strain", xi=xi, size=size, **names)
        yield from _vary_plateau_laws(rows, base, xi > 0.0)

    def suggest_records(self, evidence: FitEvidence) -> Iterator[str]:
        """Yield another temperature."""
        if len({round(one.record["temperature"][0]) for one in evidence.experiments}) < 2:
            yield "The same loop 10 to 20 K warmer: it tells C_A and C_M, which are assumed."

    def make_example(self) -> list[Record]:
        """Return a loop to 6 % with a plateau at 400 MPa."""
        loop = make_loop()
        return [make_record({"strain": 0.06 * loop, "stress": 4e8 * np.where(loop > 0.5, 1.0, loop)})]


def _stays_drawn(rows: Sequence[Record]) -> bool:
    """Return whether most of the strain remains at zero stress."""
    reach = float(np.ptp(np.concatenate([one["strain"] for one in rows])))
    left = max(float(abs(one["strain"][-1])) for one in rows)
    return left > 0.4 * reach and all(min(one["stress"][len(one) // 2 :]) < 0.1 * max(one["stress"]) for one in rows)


def _read_test(record: Record, load: str, shape: str, assumptions: Assumptions) -> Record:
    """Return the fitted rows of a tensile test with strain, stress, and its mean temperature."""
    load, shape = find_column(record, load, LOADS), find_column(record, shape, DEFORMATIONS)
    rows = read_loop(record, shape, load, assumptions)
    if shape != "strain":
        length = assumptions.take("element.length", "m", 0.1, "strain and moduli are counted from it")
        rows = with_column(rows, "strain", "1", np.asarray(rows[shape]) / length)
    if load == "force":
        section = math.pi / 4.0 * assumptions.find_diameter() ** 2
        rows = with_column(rows, "stress", "Pa", np.asarray(rows["force"]) / section)
    return with_column(rows, "temperature", "K", _find_temperature(rows, assumptions))


def _find_temperature(record: Record, assumptions: Assumptions) -> float:
    """Return the temperature of a test [K] from its mean, its file, its name, or the assumption."""
    if "temperature" in record.columns:
        return float(np.nanmean(record["temperature"]))
    celsius = assumptions.find_said(record, TEMPERATURE_WORDS, CELSIUS)
    if celsius is not None:
        return celsius + 273.15
    named = CELSIUS.search(record.name)
    if named is not None:
        assumptions.sentences.append(
            f"The name of `{record.name}` is taken to say that it was tested at {named[1]} degC."
        )
        return float(named[1]) + 273.15
    effect = "plateaus shift by some 7 MPa for every kelvin"
    return assumptions.take("environment.temperature", "K", units.parse_quantity(ROOM, "K"), effect)


def _vary_plateau_laws(rows: Sequence[Record], base: Document, stays: bool) -> Iterator[Proposal]:
    """Yield Brinson if the strain remains, Liang–Rogers and Lagoudas if it recovers."""
    strain, stress = (np.concatenate([one[name] for one in rows]) for name in ("strain", "stress"))
    kelvin = float(np.mean([one["temperature"][0] for one in rows]))
    high = float(np.percentile(stress[strain > 0.4 * strain.max()], 50.0))
    soft = _find_first_slope(rows, high)
    eps = max(0.6 * float(np.ptp(strain)), 0.005)
    moduli = (f"E_A={soft / 6e9:.4g}..{min(6.0 * soft / 1e9, 299.0):.4g} GPa", "E_M=2..200 GPa")
    shared = write_values("Pa", E_A=soft, E_M=max(0.5 * soft, 3e9)) | {"C_A": "7.5 MPa/K", "C_M": "7.5 MPa/K"}
    warm = len({round(one["temperature"][0]) for one in rows}) > 1
    places = _guess_temperatures(rows, kelvin)
    order = (f"A_f={kelvin - 363.15:.4g}..{kelvin - 253.15:.4g} degC", "A_s-A_f=-100..-0.3 K")
    order += ("M_s-A_f=-150..-0.5 K", "M_f-M_s=-100..-0.3 K")
    slopes = SLOPES if warm else ()
    ends = {"A_f": kelvin - 5.0, "M_s-A_f": 5.0 - high / SLOPE, "A_s-A_f": -10.0, "M_f-M_s": -10.0}

    def build_proposal(
        law: Document, free: Sequence[str], others: tuple[Mapping[str, float], ...] = (ends,)
    ) -> Proposal:
        document = with_law(base, shared | law)
        return Proposal(str(law["kind"]), document, tuple(free), ("stress",), rows, ("offset.stress",), others)

    if stays:
        base["element"]["initial_oriented"] = 0.0
        law = {"kind": "brinson", "eps_L": eps} | write_values("Pa", sigma_s=0.7 * high, sigma_f=1.4 * high)
        law |= write_values("K", M_f=kelvin + 5.0, M_s=kelvin + 15.0, A_s=kelvin + 30.0, A_f=kelvin + 40.0)
        free = f"sigma_s=1..{3e-6 * high:.4g} MPa", f"sigma_f-sigma_s=1..{6e-6 * high:.4g} MPa"
        yield build_proposal(law, (*moduli, "eps_L=0.002..0.19", *free), ())
        return
    cold = write_values("K", **places)
    simple = {"kind": "liang-rogers", "modulus": "mixture", "eps_L": eps}
    yield build_proposal(cold | simple, (*order, *moduli, "eps_L=0.002..0.19", *slopes))
    surface = {"kind": "lagoudas", "sigma_cal": write_value(high, "Pa"), "H_min": 0.0, "H_sat": eps, "H_k": "0.1 1/MPa"}
    surface |= dict.fromkeys(("n_1", "n_2", "n_3", "n_4"), 0.5)
    yield build_proposal(cold | surface, (*order, *moduli, "H_sat=0.002..0.19", *slopes, *ROUNDNESS))


def _guess_temperatures(rows: Sequence[Record], kelvin: float) -> dict[str, float]:
    """Return temperatures from the stresses half-way along the plateaus [K], at about `kelvin`."""
    halves = [x for x in map(_find_halves, rows) if np.isfinite(x).all()]
    loading, unloading = np.mean(halves, axis=0) if halves else (0.0, 0.0)
    martensite = kelvin - float(loading) / SLOPE
    austenite = max(kelvin - float(unloading) / SLOPE, martensite + 2.0 * NARROW)
    places = {"A_f": austenite + NARROW, "A_s": austenite - NARROW}
    return places | {"M_s": martensite + NARROW, "M_f": martensite - NARROW}


def _find_halves(one: Record) -> tuple[float, float]:
    """Return the stresses half-way along loading and unloading [Pa]; NaN without such rows."""
    strain, stress = np.asarray(one["strain"]), np.asarray(one["stress"])
    middle = np.abs((strain - strain.min()) / max(float(np.ptp(strain)), 1e-12) - 0.5) < 0.1
    stresses: dict[bool, list[float]] = {True: [], False: []}
    for first, last in trace_loop(strain).legs:
        part = stress[first : last + 1][middle[first : last + 1]]
        stresses[bool(strain[last] > strain[first])] += part.tolist()
    return tuple(float(np.median(stresses[way])) if stresses[way] else math.nan for way in (True, False))  # type: ignore[return-value]


def _find_first_slope(rows: Sequence[Record], high: float) -> float:
    """Return the stiffness at the first loading below a plateau stress [Pa]."""
    slopes: list[float] = []
    for one in rows:
        strain, stress = np.asarray(one["strain"]), np.asarray(one["stress"])
        last = trace_loop(strain).turns[1] + 1
        part = np.flatnonzero((stress[:last] > ELASTIC[0] * high) & (stress[:last] < ELASTIC[1] * high))
        if len(part) > 2 and np.ptp(strain[part]) > 0.0:
            slopes.append(float(np.polyfit(strain[part], stress[part], 1)[0]))
    good = [slope for slope in slopes if 1e9 < slope < 2e11]
    return float(np.median(good)) if good else 40e9
