"""Scenarios that may explain the logs of a recognised experiment, each with what is free and where a search begins.

Starts come from what can be read off: tangents of loops, slopes of straight branches, the time constant between drive
and answer, and the level at which the answer saturates. Transformation temperatures are free as differences
(`A_s-A_f`), so that they keep their order. What a log cannot say is assumed, said, and can be set by its dotted path.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from martensite.base import units
from martensite.base.errors import DataError, InputError, MartensiteError
from martensite.base.toml_text import as_toml
from martensite.characterise.tangent_fit import fit_tangents
from martensite.characterise.tangent_points import find_tangent_points
from martensite.characterise.time_constant import fit_rise
from martensite.fit.baselines import DriveLag, filter_drive, fit_drive_lag
from martensite.fit.experiment_kinds import DRIVEN, ExperimentKind
from martensite.scenario.overrides import change_document
from martensite.search.quantity_text import format_number
from martensite.signals.records import Record

ROWS = 160
"""Rows of a loop without rates that are compared: what a law without rates says depends on turning points only."""
ZEROED = 0.03
"""Smallest strain over range below which every record seems to count from its own zero."""
SIGMA = 100e6
"""Stress that is assumed in an element of unknown section [Pa]."""
EPS = 0.04
"""Transformation strain that is assumed in an element of unknown length."""
ROOM = "22 degC"
SLOPE = 7.5e6
"""C_A and C_M where loops at one load cannot say [Pa/K]."""
A_F = 77.0
"""Austenite finish at no stress where no temperature is measured [degC]: it sets the scale of all temperatures."""
SPREAD_STARTS = 2
"""Local searches of a driven element that begin at the best of many points."""
WIDTH, ABSORBED = 0.25e-3, "film coefficient, heat capacity and moduli absorb it"
"""Assumed diameter of an element [m], and the effect of the assumption."""
Document = dict[str, Any]

MACHINE = """
title = "{title}"
element = {{ kind = "wire", material = "flexinol-90", diameter = "{wide}", length = "{long}", initial_fraction = {xi} }}
mechanism = {{ kind = "testing-machine", control = "{control}", {size} }}
signals = {{ command = {{ kind = "log", column = "{control}" }} }}
drive = {{ kind = "temperature", waveform = {{ kind = "log" }} }}
run = {{ step = "1e3 s" }}
"""
"""Loops in a testing machine, whose temperature is prescribed."""
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
"""An element that is heated by what a log holds."""
FILM = "environment.cooling.h={:.4g}..{:.4g} W/m^2/K log"
ORDER = ("A_s-A_f=-60..-1 K", "M_s-A_f=-70..-1 K", "M_f-M_s=-60..-1 K")
"""Temperatures of a driven element, from the one that sets their scale."""
LAGOUDAS = {"kind": "lagoudas", "sigma_crit": "0 MPa"} | dict.fromkeys(("n_1", "n_2", "n_3", "n_4"), 0.45)
ROUNDNESS = tuple(f"n_{k}=0.1..1" for k in (1, 2, 3, 4))
WAIST = ("waist_f=0.1..0.98", "waist_r=0.1..0.98")
CURVES = (
    "curvature_f=-1e-3..1e-3 K/MPa^2",
    "curvature_r=-1e-3..1e-3 K/MPa^2",
    "widening_f=0..0.9 K/MPa",
    "widening_r=0..0.9 K/MPa",
)
SLOPES = ("C_A=2..30 MPa/K", "C_M=2..30 MPa/K")


@dataclass(frozen=True)
class Proposal:
    """One scenario that may explain the logs."""

    name: str
    document: Document
    free: tuple[str, ...]
    columns: tuple[str, ...]
    rows: Sequence[Record]
    """The records that it explains, with the columns that it needs."""
    each: tuple[str, ...] = ()
    others: tuple[Mapping[str, float], ...] = ()
    """Further starts: free number -> value in SI."""
    spread: int = 0
    """Local searches that begin at the best of many points over the bounds."""

    @property
    def text(self) -> str:
        """Return the scenario as TOML."""
        return as_toml(self.document)


@dataclass
class Assumptions:
    """Assumptions beyond the logs: values, and sentences about them."""

    settings: Mapping[str, Any] = field(default_factory=dict[str, Any])
    sentences: list[str] = field(default_factory=list[str])

    def take(self, path: str, unit: str, value: float, effect: str) -> float:
        """Return a value [SI]: as set, or else as assumed, which is said with its effect."""
        if path in self.settings:
            return units.parse_quantity(str(self.settings[path]), unit)
        self.sentences.append(f"`{path}` is assumed to be {write_value(value, unit)}: {effect}.")
        return value

    def find_diameter(self, matters: bool) -> float:
        """Return the diameter of the element [m]: as set; 1 mm where nothing depends on it."""
        if not matters and "element.diameter" not in self.settings:
            return 1e-3
        return self.take("element.diameter", "m", 1e-3, "stresses and moduli are counted from this section")


def write_value(value: float, unit: str) -> str:
    """Return a number as a scenario takes it, in a readable unit."""
    if unit == "K":
        return f"{value - 273.15:.5g} degC"
    if unit == "1":
        return f"{value:.5g}"
    large = {"m": ("mm", 1e-3), "m^2": ("mm^2", 1e-6), "Pa": ("MPa", 1e6), "Pa/K": ("MPa/K", 1e6)}
    words, factor = large.get(unit, (unit, 1.0))
    return f"{value / factor:.5g} {words}"


def _write_values(unit: str, **values: float) -> Document:
    return {name: write_value(value, unit) for name, value in values.items()}


def propose_scenarios(
    kind: ExperimentKind, records: Sequence[Record], settings: Mapping[str, Any]
) -> tuple[list[Proposal], list[str]]:
    """Return the scenarios for the records of an experiment, and sentences about what was assumed or done.

    Raises:
        DataError: something indispensable is missing; one sentence asks for it.
    """
    known = Assumptions(settings)
    found = list(PROPOSERS[kind.name](kind, records, known))
    if kind.name in DRIVEN:
        found = [replace(one, spread=SPREAD_STARTS) for one in found]
    if settings:
        found = [replace(one, document=change_document(one.document, settings)) for one in found]
    return found, known.sentences


def _thin_rows(record: Record, needed: Sequence[str], most: int) -> Record:
    """Return a record with few rows, in all of which the columns that are needed hold numbers."""
    whole = np.flatnonzero(np.all([np.isfinite(record[name]) for name in needed], axis=0))
    kept = whole[np.unique(np.linspace(0, len(whole) - 1, min(most, len(whole))).round().astype(int))]
    return replace(record, columns={name: [column[k] for k in kept] for name, column in record.columns.items()})


def _with_column(record: Record, name: str, unit: str, values: Any) -> Record:
    numbers = np.broadcast_to(np.asarray(values, float), len(record)).tolist()
    return replace(record, columns=record.columns | {name: numbers}, units=record.units | {name: unit})


# ---------------------------------------------------------------- loops in a testing machine


def propose_isobaric(kind: ExperimentKind, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
    """Yield the loops of temperature under constant loads."""
    width = known.find_diameter(any("stress" not in r.columns and "force" in r.columns for r in records))
    section = math.pi / 4.0 * width**2
    rows = [_read_loop(record, kind.measured[0], section, known) for record in records]
    loads = sorted(one["stress"][0] for one in rows)
    levels = 1 + int(np.sum(np.diff(loads) > 0.05 * loads[-1]))
    zeroed = len(rows) > 1 and all(min(r["strain"]) < ZEROED * float(np.ptp(r["strain"])) for r in rows)
    if zeroed:
        known.sentences.append("Every record counts strain from its own smallest value: each has a zero of its own.")
    if levels == 1:
        known.sentences.append(f"One load only: C_A and C_M are assumed to be {SLOPE / 1e6:g} MPa/K.")
    size = f'section = "{write_value(section, "m^2")}"'
    names = {"title": "Isobaric loops", "control": "stress", "wide": write_value(width, "m"), "long": "100 mm"}
    base = tomllib.loads(MACHINE.format(xi=0.0, size=size, **names))
    base["run"]["lead"] = "60 s"
    kelvin = [t for one in rows for t in one["temperature"]]
    if np.mean([one["temperature"][0] for one in rows]) <= 0.5 * (max(kelvin) + min(kelvin)):  # begins cold
        base["drive"]["waveform"]["from"] = write_value(max(kelvin) + 20.0, "K")
    yield from _vary_loop_laws(rows, base, _guess_temperatures(rows), levels, zeroed or levels == 1)


def _read_loop(record: Record, column: str, section: float, known: Assumptions) -> Record:
    """Return a loop with few rows, its strain, and its mean stress [Pa]."""
    thin = _thin_rows(record, (column, "temperature"), ROWS)
    if column != "strain":
        effect = "strain and everything in it is counted from this length"
        strain = np.asarray(thin[column], float) / known.take("element.length", "m", 0.1, effect)
        if np.corrcoef(strain, thin["temperature"])[0, 1] > 0.0:
            strain = -strain
            known.sentences.append(f"`{column}` grows on heating, and is taken as shortening.")
        thin = _with_column(thin, "strain", "1", strain)
    return _with_column(thin, "stress", "Pa", _find_load(record, section))


def _find_load(record: Record, section: float) -> float:
    """Return the mean stress of a loop [Pa]: of its column, by its force, or of its name."""
    for name, area in (("stress", 1.0), ("force", section)):
        if name in record.columns:
            return float(np.nanmean(record[name])) / area
    named = re.search(r"(\d+(?:\.\d+)?)[ _]?MPa", record.name, re.IGNORECASE)
    if named is None:
        raise DataError(
            f"Record `{record.name}` does not say under which stress it was taken: give a column `stress [MPa]` or "
            "`force [N]`, or put it into the name of the file (`wire_100MPa.csv`)."
        )
    return 1e6 * float(named[1])


def _guess_temperatures(rows: Sequence[Record]) -> dict[str, float]:
    """Return the numbers of a law by tangents; by the middles of the strokes where there are none."""
    found: list[Any] = []
    for one in rows:
        try:
            found.append(find_tangent_points(one, stress=one["stress"][0]))
        except MartensiteError:
            continue
    try:
        guess = fit_tangents(found).guess("cosine")
    except InputError:
        one, middle, apart = rows[-1], float(np.mean(rows[-1]["temperature"])), 8.0
        if found:
            middle, apart = 0.5 * (found[-1].A_half + found[-1].M_half), 0.5 * abs(found[-1].A_half - found[-1].M_half)
        zero = middle - one["stress"][0] / SLOPE
        guess = {"A_s": zero + apart - 7.0, "A_f": zero + apart + 7.0, "M_s": zero - apart + 7.0}
        guess |= {"M_f": zero - apart - 7.0, "eps_L": float(np.ptp(one["strain"]))}
    return guess if {"C_A", "C_M"} <= set(guess) else {"C_A": SLOPE, "C_M": SLOPE} | guess


def _vary_loop_laws(
    rows: Sequence[Record], base: Document, guess: Mapping[str, float], levels: int, zeroed: bool
) -> Iterator[Proposal]:
    """Lagoudas with a waist, with curved surfaces, and without both; Liang–Rogers."""
    stroke = max(float(np.ptp(one["strain"])) for one in rows)
    sigma = max(float(np.mean([one["stress"][0] for one in rows])), 1e6)
    top, apart = guess["A_f"] + 10.0, max(guess["A_f"] - guess["M_s"], 3.0)
    wide = max(guess["A_f"] - guess["A_s"], 4.0), max(guess["M_s"] - guess["M_f"], 4.0)
    shared = {"E_A": "70 GPa", "E_M": "30 GPa"} | _write_values("Pa/K", C_A=guess["C_A"], C_M=guess["C_M"])
    common = SLOPES if levels > 1 else ()
    common += ("E_A=15..200 GPa", "E_M=5..150 GPa") if levels > 2 and not zeroed else ()

    def build_proposal(name: str, law: Document, free: Sequence[str], widen: float) -> Proposal:
        above, below = (widen * w for w in wide)
        low = top - apart - max(below, above - apart + 5.0)
        places = _write_values("K", A_f=top, A_s=top - above, M_s=top - apart, M_f=low)
        temperatures = ("A_f", "A_s-A_f=-400..-1 K", "M_s-A_f=-200..-0.5 K", "M_f-M_s=-400..-1 K")
        again = {"A_s-A_f": -2.0 * above, "M_f-M_s": -2.0 * max(below, above)}
        document = base | {"element": base["element"] | {"law": shared | places | law}}
        each = ("offset.strain",) if zeroed else ()
        return Proposal(name, document, (*temperatures, *common, *free), ("strain",), rows, each, (again,))

    kelvin = [t for one in rows for t in (min(one["temperature"]), max(one["temperature"]))]
    surface = LAGOUDAS | {"alpha_A": "1e-5 1/K", "alpha_M": "6e-6 1/K", "sigma_cal": write_value(sigma, "Pa")}
    surface |= _write_values("K", T_ref=guess["A_f"])
    if levels > 2:
        surface |= {"H_min": 0.3 * stroke, "H_sat": 0.8 * stroke, "H_k": f"{1e6 / sigma:.4g} 1/MPa"}
        strain = ("H_min=0..0.15", "H_sat=0.002..0.19", "H_k=1e-3..0.1 1/MPa")
    else:
        surface |= {"H_min": stroke, "H_sat": 0.19, "H_k": "0 1/MPa"}
        strain = ("H_min=0.001..0.15",)
    strain += ("alpha_A=-2e-5..4e-5 1/K", "alpha_M=-2e-5..4e-5 1/K")
    strain += () if zeroed else (f"T_ref={min(kelvin):.5g}..{max(kelvin):.5g} K",)
    waist = {"hardening": "waisted", "waist_f": 0.8, "waist_r": 0.8, "n_1": 0.4, "n_2": 0.5, "n_3": 0.4, "n_4": 0.5}
    yield build_proposal("lagoudas with a waist", surface | waist, (*strain, *WAIST), 2.0)
    if levels > 2:
        curved = surface | waist | {"surfaces": "curved", "widening_f": "0.05 K/MPa", "widening_r": "0.05 K/MPa"}
        yield build_proposal("lagoudas with a waist and curved surfaces", curved, (*strain, *WAIST, *CURVES), 1.0)
    yield build_proposal("lagoudas", surface, (*strain, *ROUNDNESS), 1.3)
    if zeroed:
        simple = {"kind": "liang-rogers", "modulus": "mixture", "eps_L": 0.8 * stroke, "Theta": "0 Pa/K"}
        yield build_proposal("liang-rogers", simple, ("eps_L=0.001..0.19",), 1.0)


def propose_isothermal(kind: ExperimentKind, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
    """Yield the loops of strain at constant temperatures; the machine prescribes the strain."""
    load, shape = kind.measured
    width = known.find_diameter(load == "force")
    rows, length = [_thin_rows(one, kind.measured, 2 * ROWS) for one in records], 0.1
    if shape != "strain":
        length = known.take("element.length", "m", 0.1, "strain and moduli are counted from it")
        rows = [_with_column(r, "strain", "1", np.asarray(r[shape]) / length) for r in rows]
    if load == "force":
        rows = [_with_column(r, "stress", "Pa", np.asarray(r["force"]) / (math.pi / 4.0 * width**2)) for r in rows]
    rows = [_with_column(r, "temperature", "K", _find_temperature(r, known)) for r in rows]
    if len({round(one["temperature"][0]) for one in rows}) < 2:
        known.sentences.append("One temperature only: C_A and C_M are assumed to be 7.5 MPa/K.")
    size, names = f'gauge_length = "{write_value(length, "m")}"', _write_values("m", wide=width, long=length)
    title, xi = "Loops at constant temperature", float(_stays_drawn(rows))
    base = tomllib.loads(MACHINE.format(title=title, control="strain", xi=xi, size=size, **names))
    yield from _vary_plateau_laws(rows, base, xi > 0.0)


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
    shared = _write_values("Pa", E_A=soft, E_M=max(0.5 * soft, 3e9)) | {"C_A": "7.5 MPa/K", "C_M": "7.5 MPa/K"}
    shift, warm = high / SLOPE, len({round(one["temperature"][0]) for one in rows}) > 1
    places = {"A_f": kelvin - 5.0, "A_s": kelvin - 15.0, "M_s": kelvin - shift, "M_f": kelvin - shift - 10.0}
    order = (f"A_f={kelvin - 363.15:.4g}..{kelvin - 253.15:.4g} degC", "A_s-A_f=-100..-0.3 K")
    order += ("M_s-A_f=-150..-0.5 K", "M_f-M_s=-100..-0.3 K")
    slopes = SLOPES if warm else ()
    ends = {"M_s-A_f": places["M_s"] - places["A_f"], "A_s-A_f": -3.0, "M_f-M_s": -3.0}

    def build_proposal(
        law: Document, free: Sequence[str], others: tuple[Mapping[str, float], ...] = (ends,)
    ) -> Proposal:
        document = base | {"element": base["element"] | {"law": shared | law}}
        return Proposal(str(law["kind"]), document, tuple(free), ("stress",), rows, ("offset.stress",), others)

    if stays:
        base["element"]["initial_oriented"] = 0.0
        law = {"kind": "brinson", "eps_L": eps} | _write_values("Pa", sigma_s=0.7 * high, sigma_f=1.4 * high)
        law |= _write_values("K", M_f=kelvin + 5.0, M_s=kelvin + 15.0, A_s=kelvin + 30.0, A_f=kelvin + 40.0)
        free = f"sigma_s=1..{3e-6 * high:.4g} MPa", f"sigma_f-sigma_s=1..{6e-6 * high:.4g} MPa"
        yield build_proposal(law, (*moduli, "eps_L=0.002..0.19", *free), ())
        return
    cold = _write_values("K", **places)
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


# ---------------------------------------------------------------- driven elements


@dataclass(frozen=True)
class DrivenElement:
    """A driven element before it is fitted."""

    records: list[Record]
    lag: DriveLag
    section: float
    """[m²]"""
    document: Document
    """Element, surroundings and drive."""
    free: tuple[str, ...]

    @property
    def dead_weight(self) -> Document:
        """Return a mechanism that makes the stress that is assumed."""
        return {"mechanism": {"kind": "dead-weight", "mass": f"{SIGMA * self.section / 9.80665:.5g} kg"}}

    def make_proposal(
        self, name: str, document: Document, free: Sequence[str], columns: Sequence[str], zero: str = ""
    ) -> Proposal:
        """Build a proposal with its records, and optionally with a free zero of an output."""
        made = self.document | document
        return Proposal(name, made, tuple(free), tuple(columns), self.records, (f"offset.{zero}",) if zero else ())


def _start_driven(
    kind: ExperimentKind,
    records: Sequence[Record],
    known: Assumptions,
    length: float,
    diameter: tuple[float, str] = (WIDTH, ABSORBED),
) -> DrivenElement:
    """Return the film coefficient and heat capacity from where the answer saturates, and from how late it comes."""
    lag, width = fit_drive_lag(records, kind.drive, kind.measured[0]), known.take("element.diameter", "m", *diameter)
    room = units.parse_quantity(ROOM, "K")
    if all("temperature" in one.columns for one in records):
        room = min(float(np.nanpercentile(one["temperature"], 2.0)) for one in records)
    ambient = known.take("environment.temperature", "K", room, "all temperatures are counted from it")
    ohms = 9e-7 * length / (math.pi / 4.0 * width**2)
    heat = np.concatenate([filter_drive(r, kind.drive, lag.time_constant) for r in records])
    factor = {"voltage": 1.0 / ohms, "current": ohms, "duty": 25.0 / ohms}.get(kind.drive, 1.0)
    hot = A_F + 273.15 + SIGMA / SLOPE + 15.0
    if kind.name == "heating":
        hot = max(float(np.nanmax(r["temperature"])) for r in records)
    power = float(np.percentile(factor * heat, 90.0))
    h = power / (math.pi * width * length * max(hot - ambient, 10.0))
    tau = lag.time_constant or 2.0 * min(float(np.median(np.diff(r.times))) for r in records)
    per_volume = 0.6 * 4.0 * h * tau / width
    density = min(max(6450.0, per_volume / 2000.0), 29000.0)
    h, c = min(max(h, 1e-2), 9e4), min(max(per_volume / density, 1.0), 9e3)
    document = _describe_element(kind.drive, (width, length), ambient, (h, density, c, 25.0 * c))
    if kind.drive == "duty":
        document["drive"] |= {"kind": "pwm-voltage", "supply": "5 V"}
    if _begins_hot(kind.measured[0], records, lag.gain):
        document["run"]["lead"] = f"{max(6.0 * lag.time_constant, 1.0):.3g} s"
    top = min(8.0 * c, 9.9e3)
    free = (
        FILM.format(h / 6.0, h * 6.0),
        f"heat_capacity={c / 12.0:.4g}..{top:.4g} J/kg/K log",
        f"latent_heat={c * 0.3:.4g}..{min(top * 60.0, 9.9e5):.4g} J/kg log",
        *ORDER,
    )
    ohmic = kind.drive != "power" and kind.name != "resistance"
    free += ("rho_M=5.5e-7..1.4e-6 ohm*m",) if ohmic else ()
    return DrivenElement(list(records), lag, math.pi / 4.0 * width**2, document, free)


def _describe_element(
    drive: str, sizes: tuple[float, float], ambient: float, heat: tuple[float, float, float, float]
) -> Document:
    """Return an element with its film coefficient, density, heat capacity and latent heat; diameter and length in m."""
    numbers = dict(zip(("h", "density", "c", "latent"), heat, strict=True))
    numbers |= dict(zip(("diameter", "length"), (write_value(x, "m") for x in sizes), strict=True))
    document = tomllib.loads(ELEMENT.format(drive=drive, ambient=write_value(ambient, "K"), **numbers))
    top = A_F + 273.15
    document["element"]["law"] |= {"eps_L": EPS} | _write_values("Pa/K", C_A=SLOPE, C_M=SLOPE)
    document["element"]["law"] |= _write_values("K", A_f=top, A_s=top - 12.0, M_s=top - 18.0, M_f=top - 30.0)
    return document


def _begins_hot(column: str, records: Sequence[Record], gain: float) -> bool:
    """Return whether most records begin with the answer at its driven end, so that the drive was on before."""
    shares = list[float]()
    for record in records:
        low, high = np.nanpercentile(record[column], (2.0, 98.0))
        shares.append((float(np.nanmedian(record[column][:3])) - low) / max(high - low, 1e-300))
    return sum((share if gain > 0.0 else 1.0 - share) > 0.5 for share in shares) > 0.5 * len(records)


def propose_stroke(kind: ExperimentKind, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
    """Yield a weight or a bias spring that a driven element moves."""
    column = kind.measured[0]
    output = "strain" if column == "strain" else "position"
    stroke = max(float(np.nanmax(r[column]) - np.nanmin(r[column])) for r in records)
    guess = (0.1, "without effect on strain"), (stroke / (0.8 * EPS), "the transformation strain absorbs it")
    length = known.take("element.length", "m", *guess[output == "position"])
    begun = _start_driven(kind, records, known, length)
    up = (begun.lag.gain > 0.0) == (output == "position")
    if not up:
        known.sentences.append(f"`{column}` falls with the drive: its sign is turned.")
    columns = [output if up and column == output else f"{output}={column}*{1 if up else -1}"]
    free, force = (*begun.free, f"eps_L={EPS / 6.0:.4g}..0.19"), SIGMA * begun.section
    if len(kind.measured) > 1:
        spring, more = _read_spring(kind, records, begun.section, known)
        columns.append(kind.measured[1])
        yield begun.make_proposal("a bias spring", {"mechanism": spring}, (*free, *more), columns, output)
        return
    rate = 0.6 * force / (stroke if output == "position" else 0.03 * length)
    spring = {"kind": "bias-spring", "stiffness": f"{rate:.5g} N/m", "preload": f"{0.6 * force:.5g} N"}
    wanted = {path.partition(".")[2] for path in known.settings if path.startswith("mechanism.")}
    if not wanted & {"stiffness", "preload"}:
        known.sentences.append(
            f"The load is not on record: a weight and a spring are tried, at a stress of some {SIGMA / 1e6:g} MPa; "
            "temperatures absorb what it is (`mechanism.mass`, `mechanism.stiffness`)."
        )
        yield begun.make_proposal("a weight", begun.dead_weight, free, columns, output)
    if "mass" not in wanted:
        rates = () if "stiffness" in wanted else (f"stiffness={rate / 20.0:.4g}..{rate * 10.0:.4g} N/m log",)
        yield begun.make_proposal("a bias spring", {"mechanism": spring}, (*free, *rates), columns, output)


def _read_spring(
    kind: ExperimentKind, records: Sequence[Record], section: float, known: Assumptions
) -> tuple[Document, tuple[str, str]]:
    """Return a spring whose rate and preload follow from force and position, both measured, and their bounds."""
    column, load = kind.measured
    x, f = (np.concatenate([np.asarray(r[name], float) for r in records]) for name in (column, load))
    f, good = f * (section if load == "stress" else 1.0), np.isfinite(x) & np.isfinite(f)
    slope, zero = (float(v) for v in np.polyfit(x[good], f[good], 1))
    rate, least = max(abs(slope), 1e-3), max(float(np.nanmin(f)), 1e-3)
    known.sentences.append(
        f"`{load}` over `{column}` is a spring of {format_number(rate)} N/m, and {format_number(zero)} N at zero."
    )
    spring = {"kind": "bias-spring", "stiffness": f"{rate:.5g} N/m", "preload": f"{least:.5g} N"}
    bounds = f"stiffness={0.5 * rate:.5g}..{2.0 * rate:.5g} N/m", f"preload={0.2 * least:.5g}..{5.0 * least:.5g} N"
    return spring, bounds


def propose_blocked_force(kind: ExperimentKind, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
    """Yield a driven element between two grips that do not give."""
    column = kind.measured[0]
    most, least = (float(f([f(r[column]) for r in records])) for f in (np.nanmax, np.nanmin))
    length = known.take("element.length", "m", 0.1, "without effect on a force")
    wide = math.sqrt(4.0 * max(most, 1e-4) / (math.pi * 250e6))
    guess = (wide, f"at it the largest force is 250 MPa; {ABSORBED}") if column == "force" else (WIDTH, ABSORBED)
    begun = _start_driven(kind, records, known, length, guess)
    preload = max(least * (1.0 if column == "force" else begun.section), 1e-4)
    machine = {"kind": "testing-machine", "control": "elongation", "preload": f"{preload:.5g} N"}
    document = {"mechanism": machine, "signals": {"command": {"kind": "constant", "level": "0 mm"}}}
    more = ("E_A=5..250 GPa", "E_M=2..200 GPa", "C_A=1..40 MPa/K", "C_M=1..40 MPa/K")
    yield begun.make_proposal("fixed ends", document, (*begun.free, *more), (column,), column)


def propose_heating(kind: ExperimentKind, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
    """Yield a driven element under a constant load, whose temperature is measured."""
    length = known.take("element.length", "m", 0.1, "film coefficient and heat capacity absorb it")
    begun, column = _start_driven(kind, records, known, length), "temperature"
    yield begun.make_proposal(
        "with transformation", begun.dead_weight, ("A_f=30..140 degC", *begun.free), (column,), column
    )
    plain = change_document(begun.document | begun.dead_weight, {"element.latent_heat": "0 J/kg"})
    yield begun.make_proposal("heat alone", plain, begun.free[:2], (column,), column)


def propose_resistance(kind: ExperimentKind, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
    """Yield a driven element under a constant load, whose resistance is measured, or follows from volts and amperes."""
    length = known.take("element.length", "m", 0.1, "resistivities absorb it")
    begun, column = _start_driven(kind, records, known, length), kind.measured[0]
    if column == "resistance":
        ohms = [float(f([f(r[column]) for r in records])) for f in (np.nanmin, np.nanmax)]
    else:
        pairs = [np.asarray(r["voltage"]) / np.where(np.abs(r["current"]) > 0.0, r["current"], np.nan) for r in records]
        ohms = [float(np.nanpercentile(np.concatenate(pairs), q)) for q in (5.0, 95.0)]
    rho = {name: x * begun.section / length for name, x in zip(("rho_A", "rho_M"), ohms, strict=True)}
    mixture = {"kind": "mixture"} | {name: f"{x:.5g} ohm*m" for name, x in rho.items()}
    document = {"element": begun.document["element"] | {"resistance": mixture}} | begun.dead_weight
    more = tuple(f"{name}={0.3 * x:.5g}..{3.0 * x:.5g} ohm*m" for name, x in rho.items())
    yield begun.make_proposal("under a weight", document, (*begun.free, *more), (column,))


def propose_cooling(kind: ExperimentKind, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
    """Yield an element that cools from where each record begins, as if it had been heated until then."""
    rows = [_cut_hot(record) for record in records]
    rises = [fit_rise(one.times, one["temperature"]) for one in rows]
    tau, room = (float(np.median([x.value for x in xs])) for xs in zip(*((r.tau, r.final) for r in rises), strict=True))
    effect = "the film coefficient is counted from it; the time constant is not"
    width, length = known.take("element.diameter", "m", WIDTH, effect), 0.1
    c, density = known.take("element.heat_capacity", "J/kg/K", 837.0, effect), 6450.0
    h, hot = density * c * width / (4.0 * tau), max(one["temperature"][0] for one in rows)
    area, fall = math.pi / 4.0 * width**2, max(float(np.ptp(one["temperature"])) for one in rows)
    volts = math.sqrt(h * math.pi * width * length * fall * 9e-7 * length / area)
    document = _describe_element("pwm-voltage", (width, length), room, (h, density, c, 0.0))
    lead, span = f"{10.0 * tau:.4g} s", max(one.times[-1] for one in rows)
    document["run"] |= {"lead": lead, "duration": f"{10.0 * tau + span:.4g} s"}
    document["drive"] |= {"supply": f"{volts:.4g} V", "waveform": {"kind": "step", "high": 1, "until": lead}}
    begun = DrivenElement(rows, DriveLag(tau, 0.0, room, 0.0), area, document, ())
    low, high = max(room - fall, 200.0), min(room + 0.5 * fall, hot)
    free = FILM.format(h / 6.0, h * 6.0), f"environment.temperature={low}..{high} K"
    each, column = (f"drive.supply={0.3 * volts:.4g}..{3.0 * volts:.4g} V",), ("temperature",)
    yield replace(begun.make_proposal("heat alone", begun.dead_weight, free, column), each=each)
    more = ("A_f=30..140 degC", f"latent_heat={0.3 * c:.4g}..{60.0 * c:.4g} J/kg log", *ORDER)
    warm = change_document(document | begun.dead_weight, {"element.latent_heat": f"{10.0 * c:.4g} J/kg"})
    yield replace(begun.make_proposal("with transformation", warm, (*free, *more), column), each=each)


def _cut_hot(record: Record) -> Record:
    """Return a record from the time at which its temperature begins to fall, with times counted from there."""
    kept = _thin_rows(record, ("temperature",), 4 * ROWS)
    kelvin = np.asarray(kept["temperature"])
    first = int(np.flatnonzero(kelvin >= kelvin.max() - 0.02 * np.ptp(kelvin))[-1])
    found = {name: column[first:] for name, column in kept.columns.items()}
    return replace(kept, columns=found | {"time": [t - found["time"][0] for t in found["time"]]})


def add_waist(proposal: Proposal, numbers: Mapping[str, float]) -> Proposal:
    """Return a driven element with the rounder transformations of trained wires, started at fitted values."""
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


Proposer = Callable[[ExperimentKind, Sequence[Record], Assumptions], Iterator[Proposal]]
PROPOSERS: dict[str, Proposer] = {
    "isobaric": propose_isobaric,
    "isothermal": propose_isothermal,
    "stroke": propose_stroke,
    "blocked-force": propose_blocked_force,
    "heating": propose_heating,
    "resistance": propose_resistance,
    "cooling": propose_cooling,
}
