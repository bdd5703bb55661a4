"""Isothermal experiment: drawn and released at a constant temperature, stress measured."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from martensite.base import units
from martensite.fit.experiment_kinds.base import (
    EXPERIMENT_KINDS,
    AbstractExperimentKind,
    Assumptions,
    FitEvidence,
    Proposal,
    RecognisedExperiment,
)
from martensite.fit.experiment_kinds.loops import ROUNDNESS, ROWS, SLOPES, read_machine, with_law
from martensite.fit.experiment_kinds.survey import LogSurvey
from martensite.fit.experiment_kinds.values import (
    ROOM,
    SLOPE,
    Document,
    make_loop,
    make_record,
    thin_rows,
    with_column,
    write_value,
    write_values,
)
from martensite.search.quantity_text import list_names
from martensite.signals.records import Record


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

    def propose(self, found: RecognisedExperiment, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
        """Yield laws for loops of strain at constant temperatures; the machine prescribes the strain."""
        load, shape = found.measured
        width = known.find_diameter(load == "force")
        rows, length = [thin_rows(one, found.measured, 2 * ROWS) for one in records], 0.1
        if shape != "strain":
            length = known.take("element.length", "m", 0.1, "strain and moduli are counted from it")
            rows = [with_column(r, "strain", "1", np.asarray(r[shape]) / length) for r in rows]
        if load == "force":
            rows = [with_column(r, "stress", "Pa", np.asarray(r["force"]) / (math.pi / 4.0 * width**2)) for r in rows]
        rows = [with_column(r, "temperature", "K", _find_temperature(r, known)) for r in rows]
        if len({round(one["temperature"][0]) for one in rows}) < 2:
            known.sentences.append("One temperature only: C_A and C_M are assumed to be 7.5 MPa/K.")
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
    """Return whether most of the strain is left where the stress is gone."""
    reach = float(np.ptp(np.concatenate([one["strain"] for one in rows])))
    left = max(float(abs(one["strain"][-1])) for one in rows)
    return left > 0.4 * reach and all(min(one["stress"][len(one) // 2 :]) < 0.1 * max(one["stress"]) for one in rows)


def _find_temperature(record: Record, known: Assumptions) -> float:
    """Return the temperature of a loop [K]: its mean, that of its name, or the one assumed."""
    if "temperature" in record.columns:
        return float(np.nanmean(record["temperature"]))
    named = re.search(r"(\d+(?:\.\d+)?)[ _]?(?:deg)?C\b", record.name)
    if named is not None:
        return float(named[1]) + 273.15
    effect = "plateaus shift by some 7 MPa for every kelvin"
    return known.take("environment.temperature", "K", units.parse_quantity(ROOM, "K"), effect)


def _vary_plateau_laws(rows: Sequence[Record], base: Document, stays: bool) -> Iterator[Proposal]:
    """Brinson where the strain stays, Liang–Rogers and Lagoudas where it comes back."""
    strain, stress = (np.concatenate([one[name] for one in rows]) for name in ("strain", "stress"))
    kelvin = float(np.mean([one["temperature"][0] for one in rows]))
    high, soft = float(np.percentile(stress[strain > 0.4 * strain.max()], 50.0)), _find_first_slope(rows)
    eps = max(0.6 * float(np.ptp(strain)), 0.005)
    moduli = (f"E_A={soft / 6e9:.4g}..{min(6.0 * soft / 1e9, 299.0):.4g} GPa", "E_M=2..200 GPa")
    shared = write_values("Pa", E_A=soft, E_M=max(0.5 * soft, 3e9)) | {"C_A": "7.5 MPa/K", "C_M": "7.5 MPa/K"}
    shift, warm = high / SLOPE, len({round(one["temperature"][0]) for one in rows}) > 1
    places = {"A_f": kelvin - 5.0, "A_s": kelvin - 15.0, "M_s": kelvin - shift, "M_f": kelvin - shift - 10.0}
    order = (f"A_f={kelvin - 363.15:.4g}..{kelvin - 253.15:.4g} degC", "A_s-A_f=-100..-0.3 K")
    order += ("M_s-A_f=-150..-0.5 K", "M_f-M_s=-100..-0.3 K")
    slopes = SLOPES if warm else ()
    ends = {"M_s-A_f": places["M_s"] - places["A_f"], "A_s-A_f": -3.0, "M_f-M_s": -3.0}

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


def _find_first_slope(rows: Sequence[Record]) -> float:
    """Return the stiffness of the first eighth of the way up [Pa]."""
    found: list[float] = []
    for one in rows:
        strain, stress = np.asarray(one["strain"]), np.asarray(one["stress"])
        first = slice(0, max(int(np.argmax(strain)) // 8, 4))
        if np.ptp(strain[first]) > 0.0:
            found.append(float(np.polyfit(strain[first], stress[first], 1)[0]))
    good = [slope for slope in found if 1e9 < slope < 2e11]
    return float(np.median(good)) if good else 40e9
