"""Driven elements: start values of film coefficient, heat capacity and latent heat from a drive lag."""

from __future__ import annotations

import math
import tomllib
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from martensite.base import units
from martensite.fit.drive_lag import DriveLag, filter_drive, find_period, fit_drive_lag
from martensite.fit.experiment_kinds.base import (
    AbstractExperimentKind,
    Assumptions,
    FitEvidence,
    Proposal,
    RecognisedExperiment,
)
from martensite.fit.experiment_kinds.survey import LogSurvey
from martensite.fit.experiment_kinds.values import (
    EPS,
    LAGOUDAS,
    MODULI,
    ROOM,
    SIGMA,
    SLOPE,
    WAIST,
    Document,
    write_value,
    write_values,
)
from martensite.scenario.overrides import change_document
from martensite.search.quantity_text import format_number, list_names
from martensite.signals.records import Record

A_F = 77.0
"""Austenite finish at zero stress without measured temperature [degC], which sets the scale of all temperatures."""
SPREAD_STARTS = 2
"""Number of local searches of a driven element from the best of many points."""
WIDTH, ABSORBED = 0.25e-3, "film coefficient, heat capacity and moduli absorb it"
"""Assumed diameter of an element [m], and the effect of this assumption."""
ELEMENT = """
title = "A driven element"
environment = {{ temperature = "{ambient}", cooling = {{ kind = "constant", h = "{h:.5g} W/m^2/K" }} }}
drive = {{ kind = "{drive}", waveform = {{ kind = "log" }} }}
run = {{ tolerance = 3e-3 }}
[element]
kind = "wire"
material = "flexinol-90"
diameter = "{diameter}"
length = "{length}"
density = "{density:.5g} kg/m^3"
heat_capacity = "{c:.5g} J/kg/K"
latent_heat = "{latent:.5g} J/kg"
[element.law]
kind = "liang-rogers"
modulus = "mixture"
E_A = "70 GPa"
E_M = "28 GPa"
"""
"""Element heated by a logged drive."""
ABSORBED_LOAD = "temperatures at zero stress absorb it"
"""Effect of an assumed load."""
LAW = {"A_f": ("K", A_F + 273.15), "C_A": ("Pa/K", SLOPE), "C_M": ("Pa/K", SLOPE)} | {
    name: ("Pa", value) for name, value in MODULI.items()
}
"""Parameter of the law -> its unit and assumed value [SI]."""
FILM = "environment.cooling.h={:.4g}..{:.4g} W/m^2/K log"
ORDER = ("A_s-A_f=-60..-1 K", "M_s-A_f=-70..-1 K", "M_f-M_s=-60..-1 K")
"""Temperatures of a driven element, the scale-setting temperature first."""


@dataclass(frozen=True)
class DrivenElement:
    """Driven element before its fit."""

    records: list[Record]
    lag: DriveLag
    section: float
    """[m²]"""
    document: Document
    """Element, ambient and drive."""
    free: tuple[str, ...]

    def take_weight(self, assumptions: Assumptions) -> Document:
        """Return a mechanism with the given or assumed weight."""
        return {"mechanism": _take_weight(assumptions, SIGMA * self.section)}

    def make_proposal(
        self, name: str, document: Document, free: Sequence[str], columns: Sequence[str], zero: str = ""
    ) -> Proposal:
        """Build a proposal with its records, and optionally with a free zero of an output."""
        full_document = self.document | document
        return Proposal(
            name, full_document, tuple(free), tuple(columns), self.records, (f"offset.{zero}",) if zero else ()
        )


class AbstractDrivenKind(AbstractExperimentKind):
    """Kind of experiment in which a varying drive heats an element."""

    answers: ClassVar[tuple[str, ...]] = ()
    """Response columns, one of which varies with the drive."""

    def recognise(self, survey: LogSurvey) -> RecognisedExperiment | None:
        """Return the experiment if a drive and a response vary."""
        there = survey.list_varying(self.answers)
        if not survey.drives or not there:
            return None
        measured = (there[0], *self.list_further(survey)[:1])
        why = f"`{survey.drives[0]}` drives, {list_names(measured)} vary"
        return RecognisedExperiment(self, why, survey.drives[0], measured)

    def list_further(self, survey: LogSurvey) -> list[str]:
        """Return further varying columns for the comparison."""
        return []

    def propose(
        self, experiment: RecognisedExperiment, records: Sequence[Record], assumptions: Assumptions
    ) -> Iterator[Proposal]:
        """Yield the proposals of the kind, each with searches from the best of many points."""
        for one in self.propose_driven(experiment, records, assumptions):
            yield replace(one, spread=SPREAD_STARTS)

    @abstractmethod
    def propose_driven(
        self, experiment: RecognisedExperiment, records: Sequence[Record], assumptions: Assumptions
    ) -> Iterator[Proposal]:
        """Yield scenarios that may explain the records, the simplest first."""

    def suggest_records(self, evidence: FitEvidence) -> Iterator[str]:
        """Yield other periods, steps, slow ramps, and a measured temperature."""
        ones, unknown = evidence.experiments, evidence.undetermined
        if len(ones) < 2:
            yield "Record a second log with another period: only a held-out log tests the prediction."
        yield from _suggest_periods([find_period(one) for one in ones])
        if {"heat_capacity", "latent_heat", "environment.cooling.h"} & unknown:
            yield (
                "Steps that are held until nothing moves, and the free cooling after them: they part cooling, heat "
                "capacity and latent heat."
            )
        if any(name.startswith(("A_s", "M_s", "M_f", "A_f")) for name in unknown):
            yield "A slow ramp of the drive up and down: it shows where the transformations begin and end."
        if not any("temperature" in one.record.columns for one in ones):
            yield (
                "The temperature of the element, or at least of the air: without, one temperature is assumed, and sets "
                "the scale of all others."
            )


def _suggest_periods(periods: Sequence[float]) -> Iterator[str]:
    if min(periods) > 0.0 and max(periods) < 2.0 * min(periods):
        third, triple = (format_number(f * min(periods), 2) for f in (1.0 / 3.0, 3.0))
        yield (
            f"A drive with a period of {third} s or {triple} s: all records have about one cadence, which leaves heat "
            "capacity and cooling entangled."
        )


def start_driven(
    experiment: RecognisedExperiment,
    records: Sequence[Record],
    assumptions: Assumptions,
    length: float,
    diameter: tuple[float, str] = (WIDTH, ABSORBED),
) -> DrivenElement:
    """Return the film coefficient and heat capacity from the saturation and the delay of the response."""
    lag, width = (
        fit_drive_lag(records, experiment.drive, experiment.measured[0]),
        assumptions.take("element.diameter", "m", *diameter),
    )
    room = units.parse_quantity(ROOM, "K")
    if all("temperature" in one.columns for one in records):
        room = min(float(np.nanpercentile(one["temperature"], 2.0)) for one in records)
    ambient = assumptions.take("environment.temperature", "K", room, "all temperatures are counted from it")
    ohms = 9e-7 * length / (math.pi / 4.0 * width**2)
    heat = np.concatenate([filter_drive(r, experiment.drive, lag.time_constant) for r in records])
    factor = {"voltage": 1.0 / ohms, "current": ohms, "duty": 25.0 / ohms}.get(experiment.drive, 1.0)
    hot = A_F + 273.15 + SIGMA / SLOPE + 15.0
    if experiment.name == "heating":
        hot = max(float(np.nanmax(r["temperature"])) for r in records)
    power = float(np.percentile(factor * heat, 90.0))
    h = power / (math.pi * width * length * max(hot - ambient, 10.0))
    tau = lag.time_constant or 2.0 * min(float(np.median(np.diff(r.times))) for r in records)
    per_volume = 0.6 * 4.0 * h * tau / width
    density = min(max(6450.0, per_volume / 2000.0), 29000.0)
    h, c = min(max(h, 1e-2), 1.6e4), min(max(per_volume / density, 1.0), 9e3)
    document = describe_element(experiment.drive, (width, length), ambient, (h, density, c, 25.0 * c))
    if experiment.drive == "duty":
        document["drive"] |= {"kind": "pwm-voltage", "supply": "5 V"}
    if _begins_hot(experiment.measured[0], records, lag.gain):
        document["run"]["lead"] = f"{max(6.0 * lag.time_constant, 1.0):.3g} s"
    top = min(8.0 * c, 9.9e3)
    free = (
        FILM.format(h / 6.0, h * 6.0),
        f"heat_capacity={c / 12.0:.4g}..{top:.4g} J/kg/K log",
        f"latent_heat={c * 0.3:.4g}..{min(top * 60.0, 9.9e5):.4g} J/kg log",
        *ORDER,
    )
    ohmic = experiment.drive != "power" and experiment.name != "resistance"
    free += ("rho_M=5.5e-7..1.4e-6 ohm*m",) if ohmic else ()
    return DrivenElement(list(records), lag, math.pi / 4.0 * width**2, document, free)


def vary_loads(
    assumptions: Assumptions, force: float, travel: float
) -> Iterator[tuple[str, Document, tuple[str, ...]]]:
    """Yield a weight and a bias spring, with the free parameters of the spring.

    Args:
        assumptions: settings and assumptions.
        force: usual force of the element [N].
        travel: usual travel [m].
    """
    given = {path.partition(".")[2] for path in assumptions.settings if path.startswith("mechanism.")}
    if not given:
        assumptions.sentences.append("The load is not on record: a weight and a bias spring are tried.")
    if not given & {"stiffness", "preload"}:
        yield "a weight", _take_weight(assumptions, force), ()
    if "mass" not in given:
        rate = 0.6 * force / travel
        preload = assumptions.take("mechanism.preload", "N", 0.6 * force, ABSORBED_LOAD)
        spring = {"kind": "bias-spring", "stiffness": f"{rate:.5g} N/m", "preload": f"{preload:.6g} N"}
        free = f"stiffness={rate / 20.0:.4g}..{10.0 * rate:.4g} N/m log"
        yield "a bias spring", spring, () if "stiffness" in given else (free,)


def _take_weight(assumptions: Assumptions, force: float) -> Document:
    mass = assumptions.take("mechanism.mass", "kg", force / 9.80665, ABSORBED_LOAD)
    return {"kind": "dead-weight", "mass": f"{mass:.6g} kg"}


def assume_law(driven_element: DrivenElement, assumptions: Assumptions, names: Sequence[str]) -> DrivenElement:
    """Return a driven element with parameters of its law that are given or assumed, not fitted."""
    effects = {"A_f": "it sets the scale of all temperatures, because none is measured"}
    law: Document = {}
    for name in names:
        unit, value = LAW[name]
        effect = effects.get(name, "the log does not show it apart from the load")
        law[name] = write_value(assumptions.take(f"element.law.{name}", unit, value, effect), unit)
    element = driven_element.document["element"]
    whole = driven_element.document | {"element": element | {"law": element["law"] | law}}
    return replace(driven_element, document=whole)


def describe_element(
    drive: str, sizes: tuple[float, float], ambient: float, heat: tuple[float, float, float, float]
) -> Document:
    """Return an element with its film coefficient, density, heat capacity and latent heat; diameter and length in m."""
    numbers = dict(zip(("h", "density", "c", "latent"), heat, strict=True))
    numbers |= dict(zip(("diameter", "length"), (write_value(x, "m") for x in sizes), strict=True))
    document = tomllib.loads(ELEMENT.format(drive=drive, ambient=write_value(ambient, "K"), **numbers))
    top = A_F + 273.15
    document["element"]["law"] |= {"eps_L": EPS} | write_values("Pa/K", C_A=SLOPE, C_M=SLOPE)
    document["element"]["law"] |= write_values("K", A_f=top, A_s=top - 12.0, M_s=top - 18.0, M_f=top - 30.0)
    return document


def _begins_hot(column: str, records: Sequence[Record], gain: float) -> bool:
    """Return whether most records begin at the driven end of the response, with the drive already on."""
    shares = list[float]()
    for record in records:
        low, high = np.nanpercentile(record[column], (2.0, 98.0))
        shares.append((float(np.nanmedian(record[column][:3])) - low) / max(high - low, 1e-300))
    return sum((share if gain > 0.0 else 1.0 - share) > 0.5 for share in shares) > 0.5 * len(records)


def add_waist(proposal: Proposal, numbers: Mapping[str, float]) -> Proposal:
    """Return a driven element with rounder transformations of trained wires, from fitted values [SI]."""
    law = {n: value for n, value in proposal.document["element"]["law"].items() if n not in ("modulus", "eps_L")}
    law |= {n: value for n, value in LAGOUDAS.items() if n != "sigma_crit"}
    law |= {"hardening": "waisted", "sigma_cal": write_value(SIGMA, "Pa"), "waist_f": 0.7, "waist_r": 0.7}
    law |= {"H_min": EPS, "H_sat": 0.19, "H_k": "0 1/MPa"}
    free = [one.replace("eps_L", "H_min").replace("=-60..", "=-200..") for one in proposal.free]
    begin = dict(numbers) | ({"H_min": numbers["eps_L"]} if "eps_L" in numbers else {})
    begin |= {name: 2.0 * numbers[name] for name in ("A_s-A_f", "M_f-M_s")}
    document = change_document(proposal.document, {"element.law": law})
    name = f"{proposal.name}, lagoudas with a waist"
    return replace(proposal, name=name, document=document, free=(*free, *WAIST), others=(begin,), spread=0)
