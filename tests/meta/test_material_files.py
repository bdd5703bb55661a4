"""Every material file is complete, honest and dimensionally right.

Source of truth: the format of the material files (canonical names with their dimension, five
kinds of number, cited sources) and physics that holds for every alloy (`M_f < M_s`, `A_s < A_f`).
The files are read with `tomllib` alone, so an error in the library's own loader cannot hide here.
A plausible range per name catches what a dimension cannot, such as MPa/K printed as GPa/K.
"""

from __future__ import annotations

import copy
import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pint
import pytest

PACKAGE = Path(__file__).resolve().parents[2] / "src" / "martensite"
DATA = PACKAGE / "physics" / "materials" / "data"
MATERIALS = sorted(DATA.glob("*.toml"))
LAW_FILES = (PACKAGE / "physics" / "laws").glob("*.py")
LAWS = {name for path in LAW_FILES for name in re.findall(r'LAWS.register\("(.+?)"', path.read_text("utf-8"))}
BIBLIOGRAPHY = PACKAGE / "references.bib"

KINDS = {"datasheet", "measured", "fitted", "assumed", "recalled"}
SOURCE_FIELDS = {"cite", "text"}
VALUE_FIELDS = {"value", "kind", "source", "where", "note"}

# Canonical name: (unit, lowest and highest plausible magnitude in that unit).
CANONICAL: dict[str, tuple[str, float, float]] = {
    "density": ("kg/m^3", 4e3, 10e3),
    "heat_capacity": ("J/kg/K", 200, 1500),
    "latent_heat": ("kJ/kg", 1, 50),
    "thermal_conductivity": ("W/m/K", 3, 50),
    "E_A": ("GPa", 10, 120),
    "E_M": ("GPa", 5, 100),
    "Theta": ("MPa/K", -3, 3),
    "T_ref": ("K", 150, 600),
    "eps_L": ("1", 0.005, 0.12),
    "A_s": ("K", 150, 800),
    "A_f": ("K", 150, 800),
    "M_s": ("K", 150, 800),
    "M_f": ("K", 150, 800),
    "C_A": ("MPa/K", 1, 30),
    "C_M": ("MPa/K", 1, 30),
    "R_s": ("K", 150, 800),
    "R_f": ("K", 150, 800),
    "dT_R": ("K", 0, 20),
    "C_R": ("MPa/K", 5, 50),
    "eps_R": ("1", 0.001, 0.02),
    "E_R": ("GPa", 5, 100),
    "latent_R": ("1", 0, 1),
    "sigma_s": ("MPa", 5, 1000),
    "sigma_f": ("MPa", 5, 1000),
    "rho_A": ("ohm*m", 3e-7, 3e-6),
    "rho_M": ("ohm*m", 3e-7, 3e-6),
    "rho_R": ("ohm*m", 3e-7, 3e-6),
    "a_rho_R": ("1/K", -1e-3, 2e-3),
    "H_min": ("1", 0, 0.12),
    "H_sat": ("1", 0.005, 0.12),
    "H_k": ("1/Pa", 0, 1e-6),
    "sigma_crit": ("MPa", 0, 500),
    "sigma_cal": ("MPa", 1, 1000),
    "n_1": ("1", 0.05, 1),
    "n_2": ("1", 0.05, 1),
    "n_3": ("1", 0.05, 1),
    "n_4": ("1", 0.05, 1),
    "waist_f": ("1", 0, 0.98),
    "waist_r": ("1", 0, 0.98),
    "curvature_f": ("K/Pa^2", -1e-15, 1e-15),
    "curvature_r": ("K/Pa^2", -1e-15, 1e-15),
    "widening_f": ("K/Pa", 0, 1e-6),
    "widening_r": ("K/Pa", 0, 1e-6),
    "a_rho_A": ("1/K", -1e-3, 2e-3),
    "a_rho_M": ("1/K", -1e-3, 2e-3),
    "T_rho": ("K", 250, 400),
    "nu": ("1", 0.2, 0.5),
    "alpha_A": ("1/K", 1e-6, 3e-5),
    "alpha_M": ("1/K", 1e-6, 3e-5),
    "temperature_limit": ("K", 300, 900),
    "stress_limit": ("MPa", 10, 1500),
    "strain_limit": ("1", 0.005, 0.12),
    "eps_T": ("1", 0.005, 0.12),
    "sigma_L": ("MPa", 0.1, 1000),
    "T_L": ("K", 150, 800),
    "dsigma_dT": ("MPa/K", 1, 30),
    "Delta_sigma": ("MPa", 5, 1000),
    "layer_volume": ("m^3", 1e-25, 1e-21),
    "layer_time": ("s", 1e-6, 1),
}
ASCENDING = [("M_f", "M_s"), ("A_s", "A_f"), ("sigma_s", "sigma_f")]

# Works that print the maker's numbers; True where the work is not the maker's own document.
MAKERS_NUMBERS = {
    "dynalloy-f1140": False,
    "dynalloy-vendor-page": False,
    "dynalloy-table-copy": True,
    "copaci2019": True,
}

# A wire heated by its own current under the Liang-Rogers law needs all of these.
HEATED_WIRE = {
    *("density", "heat_capacity", "latent_heat", "E_A", "E_M", "Theta", "T_ref", "eps_L"),
    *("A_s", "A_f", "M_s", "M_f", "C_A", "C_M", "rho_A", "rho_M"),
}
LIMITS = {"temperature_limit", "stress_limit", "strain_limit"}
MAS_KINETICS = {
    *("density", "heat_capacity", "latent_heat", "E_A", "E_M", "eps_T", "sigma_L", "T_L"),
    *("dsigma_dT", "Delta_sigma", "layer_volume", "layer_time"),
}
NEEDED = {
    "flexinol-70": HEATED_WIRE | LIMITS,
    "flexinol-90": HEATED_WIRE | LIMITS,
    "copaci-2019": HEATED_WIRE | LIMITS,
    "migaone-15": HEATED_WIRE,
    "platform-spring": HEATED_WIRE,
    "kossoski-wire": HEATED_WIRE,
    "benchmark-liang-rogers": HEATED_WIRE,
    "niti-brinson-1993": {*("E_A", "E_M", "Theta", "T_ref", "eps_L", "A_s", "A_f", "M_s")}
    | {*("M_f", "C_A", "C_M", "sigma_s", "sigma_f")},
    "finger-mas": MAS_KINETICS,
}


@cache
def registry() -> Any:
    return pint.UnitRegistry()


@cache
def citation_keys() -> frozenset[str]:
    text = BIBLIOGRAPHY.read_text(encoding="utf-8")
    return frozenset(re.findall(r"^@\w+\{([^,\s]+),", text, flags=re.MULTILINE))


def read(path: Path) -> dict[str, Any]:
    return tomllib.loads(path.read_text(encoding="utf-8"))


def magnitude(text: str, unit: str) -> float:
    """Number of `text` in `unit`; a bare number is dimensionless."""
    number, _, printed = text.partition(" ")
    return float(registry().Quantity(float(number), printed).to(unit).magnitude)


def entry_problems(name: str, entry: dict[str, Any], sources: dict[str, Any]) -> list[str]:
    problems = [f"{name}: unknown field {field}" for field in entry.keys() - VALUE_FIELDS]
    missing = {"value", "kind", "source"} - entry.keys()
    if missing:
        return [*problems, f"{name}: missing {sorted(missing)}"]
    if not all(isinstance(text, str) and text.strip() for text in entry.values()):
        return [*problems, f"{name}: every field must be text"]
    if entry["kind"] not in KINDS:
        problems.append(f"{name}: kind {entry['kind']} is none of {sorted(KINDS)}")
    if entry["source"] not in sources:
        return [*problems, f"{name}: source {entry['source']} is not declared"]
    return problems + datasheet_problems(name, entry, sources[entry["source"]].get("cite"))


def datasheet_problems(name: str, entry: dict[str, Any], cite: str | None) -> list[str]:
    if entry["kind"] != "datasheet":
        return []
    if cite not in MAKERS_NUMBERS:
        return [f"{name}: datasheet, but {cite} does not print the maker's numbers"]
    if MAKERS_NUMBERS[cite] and not entry.get("note", "").startswith("secondary copy"):
        return [f"{name}: datasheet from a secondary copy, but the note does not say so"]
    return []


def value_problems(name: str, text: object) -> list[str]:
    if name not in CANONICAL:
        return [f"{name}: not a canonical name"]
    unit, low, high = CANONICAL[name]
    try:
        number = magnitude(str(text), unit)
    except (ValueError, pint.PintError) as error:
        return [f"{name}: value '{text}' does not parse as {unit}: {error}"]
    if not low <= number <= high:
        return [f"{name}: value '{text}' is outside {low} to {high} {unit}"]
    return []


def order_problems(values: dict[str, Any]) -> list[str]:
    problems: list[str] = []
    for low, high in ASCENDING:
        if (low in values) != (high in values):
            problems.append(f"{low} and {high} must come together")
        elif low in values:
            unit = CANONICAL[low][0]
            if magnitude(values[low]["value"], unit) >= magnitude(values[high]["value"], unit):
                problems.append(f"{low} must lie below {high}")
    return problems


def source_problems(document: dict[str, Any]) -> list[str]:
    sources = document["sources"]
    used = {entry.get("source") for entry in document["values"].values()}
    problems = [f"source {key}: no value uses it" for key in sources.keys() - used]
    for key, source in sources.items():
        if source.keys() != SOURCE_FIELDS:
            problems.append(f"source {key}: needs exactly {sorted(SOURCE_FIELDS)}")
        elif source["cite"] not in citation_keys():
            problems.append(f"source {key}: {source['cite']} is not in references.bib")
    return problems


def fit_problems(document: dict[str, Any]) -> list[str]:
    """A fit names the law that its numbers hold for, and the data that they rest on."""
    problems: list[str] = []
    if "law" in document and document["law"].get("kind") not in LAWS:
        problems.append(f"law: no law `{document['law'].get('kind')}`")
    if ("fit" in document) != ("law" in document):
        problems.append("fit: comes with the law that was fitted, and only with one")
    for record in document.get("fit", {}).get("records", []):
        hashes = [record.get(key, "") for key in ("sha256", "sha256_of_columns")]
        if not any(re.fullmatch("[0-9a-f]{64}", one) for one in hashes):
            problems.append(f"fit: record {record.get('name')} has no hash")
    if "fit" in document and not document["fit"].get("records"):
        problems.append("fit: rests on no record")
    return problems


def problems_of(document: dict[str, Any]) -> list[str]:
    """Everything wrong with one material file, as sentences; empty if it is sound."""
    expected = {"title", "summary", "limits", "sources", "values"}
    if document.keys() - {"law", "fit"} != expected:
        return [f"top level must hold exactly {sorted(expected)}, and may hold law and fit"]
    problems = [f"{key}: empty" for key in ("title", "summary", "limits") if not document[key]]
    problems += source_problems(document) + fit_problems(document)
    values = document["values"]
    for name, entry in values.items():
        problems += entry_problems(name, entry, document["sources"])
        problems += value_problems(name, entry.get("value"))
    return problems if problems else order_problems(values)


@pytest.mark.parametrize("path", MATERIALS, ids=lambda path: path.stem)
def test_material_file_is_sound(path: Path) -> None:
    assert problems_of(read(path)) == []


def test_shipped_materials_are_the_expected_ones() -> None:
    assert NEEDED.keys() <= {path.stem for path in MATERIALS}


@pytest.mark.parametrize("stem", sorted(NEEDED))
def test_material_holds_what_its_use_needs(stem: str) -> None:
    values = read(DATA / f"{stem}.toml")["values"]
    assert NEEDED[stem] - values.keys() == set()


@pytest.mark.parametrize(
    "stem, table",
    [("flexinol-90", (88, 98, 72, 62)), ("flexinol-70", (68, 78, 52, 42)), ("migaone-15", (88, 98, 72, 62))],
)
def test_zero_stress_temperatures_return_the_makers_table(stem: str, table: tuple[float, ...]) -> None:
    """Shifted to 172 MPa with its own slopes, the set gives the maker's A_s, A_f, M_s, M_f."""
    values = read(DATA / f"{stem}.toml")["values"]
    names = (("A_s", "C_A"), ("A_f", "C_A"), ("M_s", "C_M"), ("M_f", "C_M"))
    for (name, slope), celsius in zip(names, table, strict=True):
        shift = 172 / magnitude(values[slope]["value"], "MPa/K")
        shifted = magnitude(values[name]["value"], "degC") + shift
        assert shifted == pytest.approx(celsius, abs=0.05), name


def test_benchmark_resistivity_is_exact() -> None:
    """0.25 m of 0.381 mm wire is 2.075 ohm hot and 15 % more cold, to rounding."""
    values = read(DATA / "benchmark-liang-rogers.toml")["values"]
    section = 3.141592653589793 * 0.381e-3**2 / 4
    hot = magnitude(values["rho_A"]["value"], "ohm*m") * 0.25 / section
    cold = magnitude(values["rho_M"]["value"], "ohm*m") * 0.25 / section
    assert hot == pytest.approx(2.075, rel=1e-14)
    assert cold == pytest.approx(2.075 * 1.15, rel=1e-14)


def test_bibliography_keys_are_unique_and_entries_closed() -> None:
    text = BIBLIOGRAPHY.read_text(encoding="utf-8")
    keys = re.findall(r"^@\w+\{([^,\s]+),", text, flags=re.MULTILINE)
    assert len(keys) == len(set(keys)) == text.count("\n@")
    for entry in re.split(r"^(?=@)", text, flags=re.MULTILINE)[1:]:
        body = "\n".join(line for line in entry.splitlines() if not line.startswith("%"))
        assert body.count("{") == body.count("}"), body.split(",")[0]
        assert re.search(r"^  title\s+= \{", body, flags=re.MULTILINE), body.split(",")[0]


SPOILED = [
    ("values", "C_A", {"value": "6 GPa/K"}, "C_A: value '6 GPa/K' is outside"),
    ("values", "C_A", {"value": "6 MPa"}, "C_A: value '6 MPa' does not parse as MPa/K"),
    ("values", "E_A", {"value": "67"}, "E_A: value '67' does not parse as GPa"),
    ("values", "E_A", {"value": "stiff"}, "E_A: value 'stiff' does not parse as GPa"),
    ("values", "E_A", {"kind": "guessed"}, "E_A: kind guessed is none of"),
    ("values", "E_A", {"source": "nowhere"}, "E_A: source nowhere is not declared"),
    ("values", "E_A", {"page": "3"}, "E_A: unknown field page"),
    ("values", "E_A", {"note": ""}, "E_A: every field must be text"),
    ("values", "E_A", {"note": "a range"}, "E_A: datasheet from a secondary copy"),
    ("values", "rho_A", {"kind": "datasheet"}, "rho_A: datasheet, but leal2016 does not print"),
    ("values", "M_f", {"value": "60 degC"}, "M_f must lie below M_s"),
    ("values", "A_s", {"value": "90 degC"}, "A_s must lie below A_f"),
    ("values", "Young", {"value": "1 GPa"}, "Young: not a canonical name"),
    ("values", "Young", {"value": "1 GPa"}, "Young: missing ['kind', 'source']"),
    ("sources", "f1140", {"cite": "nobody"}, "source f1140: nobody is not in references.bib"),
    ("sources", "spare", {"cite": "liang1990", "text": "t"}, "source spare: no value uses it"),
]


@pytest.mark.parametrize("table, name, change, sentence", SPOILED)
def test_check_catches_a_spoiled_file(table: str, name: str, change: dict[str, str], sentence: str) -> None:
    sound = read(DATA / "flexinol-90.toml")
    spoiled = copy.deepcopy(sound)
    spoiled[table].setdefault(name, {}).update(change)
    assert problems_of(sound) == []
    assert [problem for problem in problems_of(spoiled) if problem.startswith(sentence)]


FIT = {"law": {"kind": "liang-rogers"}, "fit": {"records": [{"name": "one", "sha256": "0" * 64}]}}
SPOILED_FITS = [
    ({"law": {"kind": "liang"}}, "law: no law `liang`"),
    ({"fit": {}}, "fit: rests on no record"),
    ({"fit": {"records": [{"name": "one", "sha256": "0" * 63}]}}, "fit: record one has no hash"),
]


@pytest.mark.parametrize("change, sentence", SPOILED_FITS)
def test_check_catches_a_spoiled_fit(change: dict[str, Any], sentence: str) -> None:
    sound = read(DATA / "flexinol-90.toml")
    assert problems_of(sound | FIT) == []
    assert sentence in problems_of(sound | FIT | change)
    assert "fit: comes with the law that was fitted, and only with one" in problems_of(sound | {"law": FIT["law"]})
