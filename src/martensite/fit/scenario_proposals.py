"""Scenarios that may explain the logs of a recognised experiment, each with what is free and where a search begins.

Starts come from what can be read off: tangents of loops, slopes of straight branches, the time constant between drive
and answer, and the level at which the answer saturates. Transformation temperatures are free as differences
(`A_s-A_f`), so that they keep their order. What a log cannot say is assumed, said, and can be set by its dotted path.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from martensite.base import units
from martensite.base.errors import DataError, InputError, MartensiteError
from martensite.characterise.tangent_fit import fit_tangents
from martensite.characterise.tangent_points import find_tangent_points
from martensite.fit.baselines import DriveLag, filter_drive, fit_drive_lag
from martensite.fit.experiment_kinds import DRIVEN, ExperimentKind
from martensite.scenario.overrides import as_toml, change_document
from martensite.search.quantity_text import format_number, list_names
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
Document = dict[str, Any]


@dataclass(frozen=True)
class Proposal:
    """One scenario that may explain the logs."""

    name: str
    document: Document
    free: tuple[str, ...]
    columns: tuple[str, ...]
    each: tuple[str, ...] = ()
    others: tuple[Mapping[str, float], ...] = ()
    """Further starts: free number -> value in SI."""
    rows: Sequence[Record] = ()
    """The records that it explains, with the columns that it needs."""
    spread: int = 0
    """Local searches that begin at the best of many points over the bounds."""

    @property
    def text(self) -> str:
        """The scenario as TOML."""
        return as_toml(self.document)


@dataclass
class Assumptions:
    """What no log says: values, and the sentences about them."""

    settings: Mapping[str, Any] = field(default_factory=dict[str, Any])
    sentences: list[str] = field(default_factory=list[str])

    def take(self, path: str, unit: str, value: float, effect: str) -> float:
        """A value [SI]: as set, or else as assumed, which is said with its effect."""
        if path in self.settings:
            return units.parse_quantity(str(self.settings[path]), unit)
        self.sentences.append(f"`{path}` is assumed to be {write_value(value, unit)}: {effect}.")
        return value

    def find_diameter(self, matters: bool) -> float:
        """Diameter of the element [m]: as set; 1 mm where nothing depends on it."""
        if not matters and "element.diameter" not in self.settings:
            return 1e-3
        return self.take("element.diameter", "m", 1e-3, "stresses and moduli are counted from this section")


def write_value(value: float, unit: str) -> str:
    """A number as a scenario takes it, in a readable unit."""
    if unit == "K":
        return f"{value - 273.15:.5g} degC"
    if unit == "1":
        return f"{value:.5g}"
    for words, factor in {"m": (("mm", 1e-3),), "Pa": (("MPa", 1e6),), "m^2": (("mm^2", 1e-6),)}.get(unit, ()):
        return f"{value / factor:.5g} {words}"
    return f"{value:.5g} {unit}"


def propose_scenarios(
    kind: ExperimentKind, records: Sequence[Record], settings: Mapping[str, Any]
) -> tuple[list[Proposal], list[str]]:
    """Scenarios for the records of an experiment, and sentences about what was assumed or done.

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


def _thin_rows(record: Record, needed: Sequence[str], most: int = ROWS) -> Record:
    """A record with few rows, in all of which the columns that are needed hold numbers."""
    whole = np.flatnonzero(np.all([np.isfinite(record[name]) for name in needed], axis=0))
    kept = whole[np.unique(np.linspace(0, len(whole) - 1, min(most, len(whole))).round().astype(int))]
    return replace(record, columns={name: [column[k] for k in kept] for name, column in record.columns.items()})


def _with_column(record: Record, name: str, unit: str, values: Any) -> Record:
    return replace(record, columns=record.columns | {name: list(map(float, values))}, units=record.units | {name: unit})


# ---------------------------------------------------------------- loops under constant loads


def propose_isobaric(kind: ExperimentKind, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
    """Loops of temperature under constant loads, in a testing machine."""
    section = (
        math.pi
        / 4.0
        * known.find_diameter(any("stress" not in r.columns and "force" in r.columns for r in records)) ** 2
    )
    rows = [_read_loop(record, kind.measured[0], section, known) for record in records]
    loads = [one["stress"][0] for one in rows]
    zeroed = len(rows) > 1 and all(min(r["strain"]) < ZEROED * float(np.ptp(r["strain"])) for r in rows)
    levels = len(_group_levels(loads))
    if zeroed:
        known.sentences.append("Every record counts strain from its own smallest value: each has a zero of its own.")
    if levels == 1:
        known.sentences.append(f"One load only: C_A and C_M are assumed to be {SLOPE / 1e6:g} MPa/K.")
    guess = _guess_temperatures(rows, known)
    base = _describe_machine(rows, section)
    yield from _vary_loop_laws(rows, base, guess, levels, zeroed or levels == 1)


def _group_levels(loads: Sequence[float]) -> list[float]:
    """Loads that differ by more than a twentieth of the largest."""
    found: list[float] = []
    for load in sorted(loads):
        if not found or load - found[-1] > 0.05 * max(loads):
            found.append(load)
    return found


def _read_loop(record: Record, column: str, section: float, known: Assumptions) -> Record:
    """A loop with few rows, its strain, and its mean stress [Pa]."""
    thin = _thin_rows(record, (column, "temperature"))
    strain = np.asarray(thin[column], float)
    if column != "strain":
        length = known.take("element.length", "m", 0.1, "strain and everything in it is counted from this length")
        strain = strain / length
    if np.corrcoef(strain, thin["temperature"])[0, 1] > 0.0 and column != "strain":
        strain = -strain
        known.sentences.append(f"`{column}` grows on heating, and is taken as shortening.")
    return _with_column(
        _with_column(thin, "strain", "1", strain), "stress", "Pa", [_find_load(record, section)] * len(thin)
    )


def _find_load(record: Record, section: float) -> float:
    """Mean stress of a loop [Pa]: of its column, by its force, or of its name."""
    if "stress" in record.columns:
        return float(np.nanmean(record["stress"]))
    if "force" in record.columns:
        return float(np.nanmean(record["force"])) / section
    named = re.search(r"(\d+(?:\.\d+)?)[ _]?MPa", record.name, re.IGNORECASE)
    if named is None:
        raise DataError(
            f"Record `{record.name}` does not say under which stress it was taken: give a column `stress [MPa]` or "
            "`force [N]`, or put it into the name of the file (`wire_100MPa.csv`)."
        )
    return 1e6 * float(named[1])


def _guess_temperatures(rows: Sequence[Record], known: Assumptions) -> dict[str, float]:
    """Numbers of a law by tangents; by the middles of the strokes where there are none."""
    found: list[Any] = []
    for one in rows:
        try:
            found.append(find_tangent_points(one, stress=one["stress"][0]))
        except MartensiteError:
            continue
    try:
        guess = fit_tangents(found).guess("cosine")
    except InputError:
        points = found[-1:] or None
        one = rows[-1]
        middle = float(np.mean(one["temperature"])) if points is None else 0.5 * (points[0].A_half + points[0].M_half)
        apart, stress = (8.0 if points is None else 0.5 * abs(points[0].A_half - points[0].M_half)), one["stress"][0]
        zero = middle - stress / SLOPE
        guess = {"A_s": zero + apart - 7.0, "A_f": zero + apart + 7.0}
        guess |= {"M_s": zero - apart + 7.0, "M_f": zero - apart - 7.0, "eps_L": float(np.ptp(one["strain"]))}
    if not {"C_A", "C_M"} <= set(guess):
        guess = {"C_A": SLOPE, "C_M": SLOPE} | guess
    return guess


def _describe_machine(rows: Sequence[Record], section: float) -> Document:
    kelvin = [t for one in rows for t in one["temperature"]]
    hot_first = np.mean([one["temperature"][0] for one in rows]) > 0.5 * (max(kelvin) + min(kelvin))
    waveform = {"kind": "log"} if hot_first else {"kind": "log", "from": write_value(max(kelvin) + 20.0, "K")}
    return {
        "title": "Isobaric loops",
        "element": {
            "kind": "wire",
            "material": "flexinol-90",
            "diameter": write_value(math.sqrt(4.0 * section / math.pi), "m"),
            "length": "100 mm",
            "initial_fraction": 0.0,
        },
        "mechanism": {"kind": "testing-machine", "control": "stress", "section": write_value(section, "m^2")},
        "signals": {"command": {"kind": "log", "column": "stress"}},
        "drive": {"kind": "temperature", "waveform": waveform},
        "run": {"lead": "60 s", "step": "1e3 s"},
    }


def _vary_loop_laws(
    rows: Sequence[Record], base: Document, guess: Mapping[str, float], levels: int, zeroed: bool
) -> Iterator[Proposal]:
    """Lagoudas with a waist and without, Liang–Rogers."""
    each = ("offset.strain",) if zeroed else ()
    stroke = max(float(np.ptp(one["strain"])) for one in rows)
    sigma = max(float(np.mean([one["stress"][0] for one in rows])), 1e6)
    apart = max(guess["A_f"] - guess["M_s"], 3.0)
    shared = {
        "E_A": "70 GPa",
        "E_M": "30 GPa",
        "A_f": write_value(guess["A_f"] + 10.0, "K"),
        "C_A": write_value(guess["C_A"], "Pa") + "/K",
        "C_M": write_value(guess["C_M"], "Pa") + "/K",
    }
    slopes = ("C_A=2..30 MPa/K", "C_M=2..30 MPa/K") if levels > 1 else ()
    moduli = ("E_A=15..200 GPa", "E_M=5..150 GPa") if levels > 2 and not zeroed else ()
    wide = max(guess["A_f"] - guess["A_s"], 4.0), max(guess["M_s"] - guess["M_f"], 4.0)

    def build(name: str, law: Document, free: Sequence[str], widen: float) -> Proposal:
        above, below = (widen * w for w in wide)
        law = (
            shared
            | {
                "A_s": write_value(guess["A_f"] + 10.0 - above, "K"),
                "M_s": write_value(guess["A_f"] + 10.0 - apart, "K"),
                "M_f": write_value(guess["A_f"] + 10.0 - apart - max(below, above - apart + 5.0), "K"),
            }
            | law
        )
        temperatures = ("A_f", "A_s-A_f=-400..-1 K", "M_s-A_f=-200..-0.5 K", "M_f-M_s=-400..-1 K")
        again = {"A_s-A_f": -2.0 * above, "M_f-M_s": -2.0 * max(below, above)}
        document = base | {"element": base["element"] | {"law": law}}
        return Proposal(name, document, (*temperatures, *slopes, *moduli, *free), ("strain",), each, (again,), rows)

    expansion = ("alpha_A=-2e-5..4e-5 1/K", "alpha_M=-2e-5..4e-5 1/K")
    kelvin = [t for one in rows for t in (min(one["temperature"]), max(one["temperature"]))]
    place = () if zeroed else (f"T_ref={min(kelvin):.5g}..{max(kelvin):.5g} K",)
    surface = {
        "kind": "lagoudas",
        "sigma_cal": write_value(sigma, "Pa"),
        "sigma_crit": "0 MPa",
        "n_1": 0.45,
        "n_2": 0.45,
        "n_3": 0.45,
        "n_4": 0.45,
        "alpha_A": "1e-5 1/K",
        "alpha_M": "6e-6 1/K",
        "T_ref": write_value(guess["A_f"], "K"),
    }
    if levels > 2:
        strain = ("H_min=0..0.15", "H_sat=0.002..0.19", "H_k=1e-3..0.1 1/MPa")
        surface |= {"H_min": 0.3 * stroke, "H_sat": 0.8 * stroke, "H_k": f"{1e6 / sigma:.4g} 1/MPa"}
    else:
        strain = ("H_min=0.001..0.15",)
        surface |= {"H_min": stroke, "H_sat": 0.19, "H_k": "0 1/MPa"}
    waist = surface | {"hardening": "waisted", "waist_f": 0.8, "waist_r": 0.8}
    waist |= {"n_1": 0.4, "n_2": 0.5, "n_3": 0.4, "n_4": 0.5}
    yield build(
        "lagoudas with a waist", waist, (*strain, *expansion, *place, "waist_f=0.1..0.98", "waist_r=0.1..0.98"), 2.0
    )
    roundness = tuple(f"n_{k}=0.1..1" for k in (1, 2, 3, 4))
    yield build("lagoudas", surface, (*strain, *expansion, *place, *roundness), 1.3)
    simple = {"kind": "liang-rogers", "modulus": "mixture", "eps_L": 0.8 * stroke, "Theta": "0 Pa/K"}
    if zeroed:
        yield build("liang-rogers", simple, ("eps_L=0.001..0.19",), 1.0)


# ---------------------------------------------------------------- loops at a constant temperature


def propose_isothermal(kind: ExperimentKind, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
    """Loops of strain at constant temperatures, in a testing machine that prescribes the strain."""
    load, shape = kind.measured
    diameter = known.find_diameter(load == "force")
    rows, length = [_thin_rows(one, kind.measured, 2 * ROWS) for one in records], 0.1
    if shape != "strain":
        length = known.take("element.length", "m", 0.1, "strain and moduli are counted from it")
        rows = [_with_column(r, "strain", "1", np.asarray(r[shape]) / length) for r in rows]
    section = math.pi / 4.0 * diameter**2
    if load == "force":
        rows = [_with_column(r, "stress", "Pa", np.asarray(r["force"]) / section) for r in rows]
    rows = [_with_column(r, "temperature", "K", _find_temperatures(r, known)) for r in rows]
    if len({round(one["temperature"][0]) for one in rows}) < 2:
        known.sentences.append("One temperature only: C_A and C_M are assumed to be 7.5 MPa/K.")
    yield from _vary_plateau_laws(rows, diameter, length)


def _find_temperatures(record: Record, known: Assumptions) -> Any:
    """The temperature of a loop [K]: its mean, that of its name, or the one assumed."""
    if "temperature" in record.columns:
        return [float(np.nanmean(record["temperature"]))] * len(record)
    named = re.search(r"(\d+(?:\.\d+)?)[ _]?(?:deg)?C\b", record.name)
    given = units.parse_quantity(ROOM, "K") if named is None else float(named[1]) + 273.15
    if named is None:
        given = known.take("environment.temperature", "K", given, "plateaus shift by some 7 MPa for every kelvin")
    return [given] * len(record)


def _vary_plateau_laws(rows: Sequence[Record], diameter: float, length: float) -> Iterator[Proposal]:
    strain, stress = (np.concatenate([one[name] for one in rows]) for name in ("strain", "stress"))
    kelvin = float(np.mean([one["temperature"][0] for one in rows]))
    warm = len({round(one["temperature"][0]) for one in rows}) > 1
    left = max(float(abs(one["strain"][-1])) for one in rows) / float(np.ptp(strain))
    stays = all(min(one["stress"][len(one) // 2 :]) < 0.1 * max(one["stress"]) for one in rows) and left > 0.4
    high = float(np.percentile(stress[strain > 0.4 * strain.max()], 50.0))
    soft = _find_first_slope(rows)
    eps = max(0.6 * float(np.ptp(strain)), 0.005)
    element = {
        "kind": "wire",
        "material": "flexinol-90",
        "diameter": write_value(diameter, "m"),
        "length": write_value(length, "m"),
        "initial_fraction": 1.0 if stays else 0.0,
    }
    base: Document = {
        "title": "Loops at constant temperature",
        "mechanism": {"kind": "testing-machine", "control": "strain", "gauge_length": write_value(length, "m")},
        "signals": {"command": {"kind": "log", "column": "strain"}},
        "drive": {"kind": "temperature", "waveform": {"kind": "log"}},
        "run": {"step": "1e3 s"},
    }
    moduli = (f"E_A={soft / 6e9:.4g}..{min(6.0 * soft / 1e9, 299.0):.4g} GPa", "E_M=2..200 GPa", "eps_L=0.002..0.19")
    law: Document = {"E_A": write_value(soft, "Pa"), "E_M": write_value(max(0.5 * soft, 3e9), "Pa"), "eps_L": eps}
    slopes = ("C_A=2..30 MPa/K", "C_M=2..30 MPa/K") if warm else ()
    law |= {"C_A": "7.5 MPa/K", "C_M": "7.5 MPa/K"}
    if stays:
        law |= {"kind": "brinson", "sigma_s": write_value(0.7 * high, "Pa"), "sigma_f": write_value(1.4 * high, "Pa")}
        law |= {name: write_value(kelvin + up, "K") for name, up in (("M_f", 5), ("M_s", 15), ("A_s", 30), ("A_f", 40))}
        element |= {"law": law, "initial_oriented": 0.0}
        free = (*moduli, f"sigma_s=1..{3e-6 * high:.4g} MPa", f"sigma_f-sigma_s=1..{6e-6 * high:.4g} MPa")
        yield Proposal("brinson", base | {"element": element}, free, ("stress",), ("offset.stress",), (), rows)
        return
    shift = high / SLOPE
    places = {"A_f": kelvin - 5.0, "A_s": kelvin - 15.0, "M_s": kelvin - shift, "M_f": kelvin - shift - 10.0}
    law |= {name: write_value(value, "K") for name, value in places.items()}
    order = (
        f"A_f={kelvin - 363.15:.4g}..{kelvin - 253.15:.4g} degC",
        "A_s-A_f=-100..-0.3 K",
        "M_s-A_f=-150..-0.5 K",
        "M_f-M_s=-100..-0.3 K",
    )
    ends = {"M_s-A_f": places["M_s"] - places["A_f"], "A_s-A_f": -3.0, "M_f-M_s": -3.0}
    for kind in ("liang-rogers", "lagoudas"):
        more, options = slopes, {"kind": kind, "modulus": "mixture"}
        if kind == "lagoudas":
            options = {
                "kind": kind,
                "sigma_cal": write_value(high, "Pa"),
                "H_min": 0.0,
                "H_sat": eps,
                "H_k": "0.1 1/MPa",
                "n_1": 0.5,
                "n_2": 0.5,
                "n_3": 0.5,
                "n_4": 0.5,
            }
            more = (*slopes, "n_1=0.1..1", "n_2=0.1..1", "n_3=0.1..1", "n_4=0.1..1")
        own = {k: v for k, v in law.items() if not (kind == "lagoudas" and k == "eps_L")}
        names = [m.replace("eps_L", "H_sat") if kind == "lagoudas" else m for m in moduli]
        document = base | {"element": element | {"law": options | own}}
        yield Proposal(kind, document, (*order, *names, *more), ("stress",), ("offset.stress",), (ends,), rows)


def _find_first_slope(rows: Sequence[Record]) -> float:
    """Stiffness of the first fifth of the way up [Pa]."""
    found: list[float] = []
    for one in rows:
        strain, stress = np.asarray(one["strain"]), np.asarray(one["stress"])
        top = int(np.argmax(strain))
        first = slice(0, max(top // 8, 4))
        if np.ptp(strain[first]) > 0.0:
            found.append(float(np.polyfit(strain[first], stress[first], 1)[0]))
    good = [slope for slope in found if 1e9 < slope < 2e11]
    return float(np.median(good)) if good else 40e9


# ---------------------------------------------------------------- driven elements


@dataclass(frozen=True)
class DrivenStart:
    """What is known of a driven element before it is fitted, in SI."""

    lag: DriveLag
    diameter: float
    length: float
    sigma: float
    """Stress in it at rest [Pa]."""
    ambient: float
    """[K]"""
    h: float
    heat_capacity: float
    density: float

    @property
    def section(self) -> float:
        """Of the element [m²]."""
        return math.pi / 4.0 * self.diameter**2


def _start_driven(kind: ExperimentKind, records: Sequence[Record], known: Assumptions, length: float) -> DrivenStart:
    """Film coefficient and heat capacity from where the answer saturates, and from how late it comes."""
    lag = fit_drive_lag(records, kind.drive, kind.measured[0])
    diameter = known.take("element.diameter", "m", 0.25e-3, "film coefficient, heat capacity and moduli absorb it")
    ambient = known.take("environment.temperature", "K", _find_ambient(records), "all temperatures are counted from it")
    sigma, area = SIGMA, math.pi / 4.0 * diameter**2
    heat = np.concatenate([filter_drive(r, kind.drive, lag.time_constant) for r in records])
    ohms = 9e-7 * length / area
    factor = {"voltage": 1.0 / ohms, "current": ohms, "duty": 25.0 / ohms}.get(kind.drive, 1.0)
    power = float(np.percentile(factor * heat, 90.0))
    hot = A_F + 273.15 + sigma / SLOPE + 15.0
    if kind.name == "heating":
        hot = max(float(np.nanmax(r["temperature"])) for r in records)
    h = power / (math.pi * diameter * length * max(hot - ambient, 10.0))
    tau = lag.time_constant or 2.0 * min(float(np.median(np.diff(r.times))) for r in records)
    per_volume = 0.6 * 4.0 * h * tau / diameter
    density = min(max(6450.0, per_volume / 2000.0), 29000.0)
    return DrivenStart(
        lag, diameter, length, sigma, ambient, min(max(h, 1e-2), 9e4), min(max(per_volume / density, 1.0), 9e3), density
    )


def _find_ambient(records: Sequence[Record]) -> float:
    if all("temperature" in one.columns for one in records):
        return min(float(np.nanpercentile(one["temperature"], 2.0)) for one in records)
    return units.parse_quantity(ROOM, "K")


def _begins_hot(kind: ExperimentKind, records: Sequence[Record], lag: DriveLag) -> bool:
    """Whether most records begin with the answer at its driven end, so that the drive was on before."""
    hot = 0
    for record in records:
        y = np.asarray(record[kind.measured[0]], float)
        low, high = np.nanpercentile(y, (2.0, 98.0))
        share = (float(np.nanmedian(y[:3])) - low) / max(high - low, 1e-300)
        hot += (share if lag.gain > 0.0 else 1.0 - share) > 0.5
    return hot > 0.5 * len(records)


def _describe_driven(kind: ExperimentKind, begun: DrivenStart, records: Sequence[Record]) -> tuple[Document, list[str]]:
    """Element, surroundings and drive, and what is free in them."""
    hot = _begins_hot(kind, records, begun.lag)
    source: Document = {"kind": kind.drive, "waveform": {"kind": "log"}}
    if kind.drive == "duty":
        source |= {"kind": "pwm-voltage", "supply": "5 V"}
    shift = 273.15 + A_F
    law = {
        "kind": "liang-rogers",
        "modulus": "mixture",
        "E_A": "70 GPa",
        "E_M": "28 GPa",
        "eps_L": EPS,
        "C_A": "7.5 MPa/K",
        "C_M": "7.5 MPa/K",
        "A_f": write_value(shift, "K"),
        "A_s": write_value(shift - 12.0, "K"),
        "M_s": write_value(shift - 18.0, "K"),
        "M_f": write_value(shift - 30.0, "K"),
    }
    document: Document = {
        "title": "A driven element",
        "element": {
            "kind": "wire",
            "material": "flexinol-90",
            "diameter": write_value(begun.diameter, "m"),
            "length": write_value(begun.length, "m"),
            "density": f"{begun.density:.5g} kg/m^3",
            "heat_capacity": f"{begun.heat_capacity:.5g} J/kg/K",
            "latent_heat": f"{begun.heat_capacity * 25.0:.5g} J/kg",
            "law": law,
        },
        "environment": {
            "temperature": write_value(begun.ambient, "K"),
            "cooling": {"kind": "constant", "h": f"{begun.h:.5g} W/m^2/K"},
        },
        "drive": source,
        "run": {"tolerance": 3e-3} | ({"lead": f"{max(6.0 * begun.lag.time_constant, 1.0):.3g} s"} if hot else {}),
    }
    top = min(8.0 * begun.heat_capacity, 9.9e3)
    free = [
        f"environment.cooling.h={begun.h / 6.0:.4g}..{begun.h * 6.0:.4g} W/m^2/K log",
        f"heat_capacity={begun.heat_capacity / 12.0:.4g}..{top:.4g} J/kg/K log",
        f"latent_heat={begun.heat_capacity * 0.3:.4g}..{min(top * 60.0, 9.9e5):.4g} J/kg log",
        "A_s-A_f=-60..-1 K",
        "M_s-A_f=-70..-1 K",
        "M_f-M_s=-60..-1 K",
    ]
    if kind.drive in ("voltage", "current", "duty") or kind.name == "resistance":
        free.append("rho_M=5.5e-7..1.4e-6 ohm*m")
    return document, free


def propose_stroke(kind: ExperimentKind, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
    """A weight or a bias spring that a driven element moves."""
    column = kind.measured[0]
    stroke = max(float(np.nanmax(r[column]) - np.nanmin(r[column])) for r in records)
    if column == "strain":
        length = known.take("element.length", "m", 0.1, "without effect on strain")
    else:
        length = known.take("element.length", "m", stroke / (0.8 * EPS), "the transformation strain absorbs it")
    begun = _start_driven(kind, records, known, length)
    output = "strain" if column == "strain" else "position"
    up = begun.lag.gain > 0.0 if output == "position" else begun.lag.gain < 0.0
    if not up:
        known.sentences.append(f"`{column}` falls with the drive: its sign is turned.")
    compared = f"{output}={column}" if up and column == output else f"{output}={column}*{1.0 if up else -1.0:g}"
    columns = (output,) if compared == f"{output}={output}" else (compared,)
    base, free = _describe_driven(kind, begun, records)
    strain = f"eps_L={EPS / 6.0:.4g}..0.19"
    force = begun.sigma * begun.section
    rows = list(records)
    if len(kind.measured) > 1:
        yield _carry_spring(kind, rows, base, [*free, strain], columns, known)
        return
    weight = {"kind": "dead-weight", "mass": f"{force / 9.80665:.5g} kg"}
    rate = 0.6 * force / stroke if output == "position" else 0.6 * force / (0.03 * length)
    spring = {"kind": "bias-spring", "stiffness": f"{rate:.5g} N/m", "preload": f"{0.6 * force:.5g} N"}
    wanted = {path.partition(".")[2] for path in known.settings if path.startswith("mechanism.")}
    each = (f"offset.{output}",)
    if not wanted & {"stiffness", "preload"}:
        known.sentences.append(
            "The load is not on record: a weight and a spring are tried, at a stress of some "
            f"{begun.sigma / 1e6:g} MPa; temperatures absorb what it is (`mechanism.mass`, `mechanism.stiffness`)."
        )
        yield Proposal("a weight", base | {"mechanism": weight}, (*free, strain), columns, each, (), rows)
    if "mass" not in wanted:
        rates = () if "stiffness" in wanted else (f"stiffness={rate / 20.0:.4g}..{rate * 10.0:.4g} N/m log",)
        yield Proposal("a bias spring", base | {"mechanism": spring}, (*free, strain, *rates), columns, each, (), rows)


def _carry_spring(
    kind: ExperimentKind,
    rows: Sequence[Record],
    base: Document,
    free: Sequence[str],
    columns: tuple[str, ...],
    known: Assumptions,
) -> Proposal:
    """A spring whose rate and preload follow from force and position, both measured."""
    column, load = kind.measured
    x, f = (np.concatenate([np.asarray(r[name], float) for r in rows]) for name in (column, load))
    good = np.isfinite(x) & np.isfinite(f)
    if load == "stress":
        f = f * math.pi / 4.0 * units.parse_quantity(base["element"]["diameter"], "m") ** 2
    rate, zero = (float(v) for v in np.polyfit(x[good], f[good], 1))
    rate, least = max(abs(rate), 1e-3), max(float(np.nanmin(f)), 1e-3)
    known.sentences.append(
        f"`{load}` over `{column}` is a spring of {format_number(rate)} N/m, and {format_number(zero)} N at zero."
    )
    spring = {"kind": "bias-spring", "stiffness": f"{rate:.5g} N/m", "preload": f"{least:.5g} N"}
    more = (f"stiffness={0.5 * rate:.5g}..{2.0 * rate:.5g} N/m", f"preload={0.2 * least:.5g}..{5.0 * least:.5g} N")
    each = (f"offset.{columns[0].partition('=')[0]}",)
    return Proposal("a bias spring", base | {"mechanism": spring}, (*free, *more), (*columns, load), each, (), rows)


def propose_blocked_force(kind: ExperimentKind, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
    """A driven element between two grips that do not give."""
    column = kind.measured[0]
    most, least = (float(f([f(r[column]) for r in records])) for f in (np.nanmax, np.nanmin))
    length = known.take("element.length", "m", 0.1, "without effect on a force")
    begun = _start_driven(kind, records, known, length)
    if column == "force" and "element.diameter" not in known.settings:
        diameter = math.sqrt(4.0 * max(most, 1e-4) / (math.pi * 250e6))
        known.sentences[:] = [s for s in known.sentences if not s.startswith("`element.diameter`")]
        again = Assumptions({**known.settings, "element.diameter": write_value(diameter, "m")})
        known.sentences.append(
            f"`element.diameter` is assumed to be {write_value(diameter, 'm')}, at which the largest force is "
            "250 MPa: moduli, film coefficient and heat capacity absorb it."
        )
        begun = _start_driven(kind, records, again, length)
    base, free = _describe_driven(kind, begun, records)
    preload = max(least if column == "force" else least * begun.section, 1e-4)
    machine = {"kind": "testing-machine", "control": "elongation", "preload": f"{preload:.5g} N"}
    document = base | {"mechanism": machine, "signals": {"command": {"kind": "constant", "level": "0 mm"}}}
    more = ("E_A=5..250 GPa", "E_M=2..200 GPa", "C_A=1..40 MPa/K", "C_M=1..40 MPa/K")
    columns = (column,)
    yield Proposal("fixed ends", document, (*free, *more), columns, (f"offset.{column}",), (), list(records))


def propose_heating(kind: ExperimentKind, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
    """A driven element under a constant load, whose temperature is measured."""
    length = known.take("element.length", "m", 0.1, "film coefficient and heat capacity absorb it")
    begun = _start_driven(kind, records, known, length)
    base, free = _describe_driven(kind, begun, records)
    mass = f"{begun.sigma * begun.section / 9.80665:.5g} kg"
    document = base | {"mechanism": {"kind": "dead-weight", "mass": mass}}
    columns = ("temperature",)
    yield Proposal(
        "with transformation",
        document,
        ("A_f=30..140 degC", *free),
        columns,
        ("offset.temperature",),
        (),
        list(records),
    )
    plain = change_document(document, {"element.latent_heat": "0 J/kg"})
    yield Proposal("heat alone", plain, tuple(free[:2]), columns, ("offset.temperature",), (), list(records))


def propose_resistance(kind: ExperimentKind, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
    """A driven element under a constant load, whose resistance is measured, or follows from volts and amperes."""
    length = known.take("element.length", "m", 0.1, "resistivities absorb it")
    begun = _start_driven(kind, records, known, length)
    base, free = _describe_driven(kind, begun, records)
    column = kind.measured[0]
    if column == "resistance":
        ohms = [float(f([f(r[column]) for r in records])) for f in (np.nanmin, np.nanmax)]
    else:
        pairs = [np.asarray(r["voltage"]) / np.where(np.abs(r["current"]) > 0.0, r["current"], np.nan) for r in records]
        ohms = [float(np.nanpercentile(np.concatenate(pairs), q)) for q in (5.0, 95.0)]
    rho = [x * begun.section / length for x in ohms]
    mass = f"{begun.sigma * begun.section / 9.80665:.5g} kg"
    element = base["element"] | {
        "resistance": {"kind": "mixture", "rho_A": f"{rho[0]:.5g} ohm*m", "rho_M": f"{rho[1]:.5g} ohm*m"}
    }
    document = base | {"element": element, "mechanism": {"kind": "dead-weight", "mass": mass}}
    kept = [one for one in free if not one.startswith("rho_M")]
    more = tuple(f"{n}={0.3 * x:.5g}..{3.0 * x:.5g} ohm*m" for n, x in zip(("rho_A", "rho_M"), rho, strict=True))
    yield Proposal("under a weight", document, (*kept, *more), (column,), (), (), list(records))


def refuse_cooling(kind: ExperimentKind, records: Sequence[Record], known: Assumptions) -> Iterator[Proposal]:
    """Free cooling has a command of its own."""
    names = list_names([one.name for one in records])
    raise DataError(
        f"{names}: free cooling; `martensite fit h LOG` finds its film coefficient, which a scenario then takes as "
        "`environment.cooling.h`."
    )


def add_waist(proposal: Proposal, numbers: Mapping[str, float]) -> Proposal:
    """A driven element with rounder transformations, that of trained wires; the search begins at numbers found."""
    law = {
        name: value for name, value in proposal.document["element"]["law"].items() if name not in ("modulus", "eps_L")
    }
    law |= {"kind": "lagoudas", "hardening": "waisted", "sigma_cal": write_value(SIGMA, "Pa")}
    law |= {"H_min": EPS, "H_sat": 0.19, "H_k": "0 1/MPa", "waist_f": 0.7, "waist_r": 0.7}
    law |= dict.fromkeys(("n_1", "n_2", "n_3", "n_4"), 0.45)
    free = [one.replace("eps_L", "H_min").replace("=-60..", "=-200..") for one in proposal.free]
    begin = dict(numbers) | ({"H_min": numbers["eps_L"]} if "eps_L" in numbers else {})
    begin |= {name: 2.0 * numbers[name] for name in ("A_s-A_f", "M_f-M_s")}
    document = change_document(proposal.document, {"element.law": law})
    more = ("waist_f=0.1..0.98", "waist_r=0.1..0.98")
    return replace(
        proposal,
        name=f"{proposal.name}, lagoudas with a waist",
        document=document,
        free=(*free, *more),
        others=(begin,),
        spread=0,
    )


Proposer = Callable[[ExperimentKind, Sequence[Record], Assumptions], Iterator[Proposal]]
PROPOSERS: dict[str, Proposer] = {
    "isobaric": propose_isobaric,
    "isothermal": propose_isothermal,
    "stroke": propose_stroke,
    "blocked-force": propose_blocked_force,
    "heating": propose_heating,
    "resistance": propose_resistance,
    "cooling": refuse_cooling,
}
