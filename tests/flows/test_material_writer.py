"""A material file that is written from a fit holds its numbers, its law, and what they rest on.

Source of truth: the fit itself, the bytes of the records (hashed here), and the material that
the scenario began with. Files are read with `tomllib` alone where the loader could hide a fault.
"""

from __future__ import annotations

import hashlib
import math
import struct
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from builders import PLAIN_LAW, plain_law, plain_system
from command import Command
from finished_fits import FREE, LAW, TEXT, Sample, poor_sample, sample
from hypothesis import given
from hypothesis import strategies as st

from martensite.actuators.assembly import Actuator, Group, Machine
from martensite.actuators.mechanisms.pulley import AntagonisticPulley
from martensite.base import units
from martensite.base.errors import InputError
from martensite.fit.material_files import write_material
from martensite.fit.material_numbers import find_law, name_canonically
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.physics.materials.base import NAMES, load_material
from martensite.scenario.citations import read_bibliography
from martensite.scenario.exact_text import exact_text, format_quantity, shown_range
from martensite.scenario.laws import configure_laws, law_words
from martensite.scenario.scenario import read_scenario


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Sample:
    """A good fit."""
    return sample(tmp_path_factory.mktemp("plain"))


@pytest.fixture(scope="module")
def poor(tmp_path_factory: pytest.TempPathFactory) -> Sample:
    """A fit with a parameter at its bound, one without effect, one for every record."""
    return poor_sample(tmp_path_factory.mktemp("poor"))


def document(one: Sample, name: str = "mine.toml", **how: Any) -> dict[str, Any]:
    """What is written, read without the package."""
    path = one.folder / name
    arguments: dict[str, Any] = {"scenario": one.scenario} | how
    write_material(one.fit, path, **arguments)
    return tomllib.loads(path.read_text(encoding="utf-8"))


# ---------------------------------------------------------------- numbers


def test_the_file_gives_the_fitted_numbers_to_the_last_digit(plain: Sample) -> None:
    document(plain)
    material = load_material(plain.folder / "mine.toml")
    for name in FREE:
        assert material.values[name].value == plain.fit[name]
        assert material.values[name].kind == "fitted"


def differing(one: Sample, path: Path) -> list[str]:
    """Numbers of a scenario with the material of a file that are not those of the fit."""
    text = TEXT.replace('"flexinol-90"', f'"{path}"').replace(LAW, "")
    used = {leaf.path: leaf.value for leaf in read_scenario(text).system.leaves()}
    fitted = {leaf.path: leaf.value for leaf in one.fit.system().leaves()}
    return [key for key in used if key != "mechanism.mass" and used[key] != fitted[key]]


def test_a_scenario_with_the_material_alone_is_the_fitted_system(plain: Sample) -> None:
    document(plain)
    assert differing(plain, plain.folder / "mine.toml") == []


def test_a_changed_digit_is_noticed(plain: Sample) -> None:
    document(plain)
    text = (plain.folder / "mine.toml").read_text(encoding="utf-8")
    number = exact_text(plain.fit["eps_L"], "1")
    last = str((int(number[-1]) + 5) % 10)
    spoiled = plain.folder / "spoiled.toml"
    spoiled.write_text(text.replace(number, number[:-1] + last, 1), encoding="utf-8")
    assert differing(plain, spoiled) == ["element.law.eps_L"]


def test_fewer_digits_are_rounded_digits(plain: Sample) -> None:
    values = document(plain, digits=4)["values"]
    assert values["A_s"]["value"] == f"{plain.fit['A_s'] - 273.15:.2f} degC"
    assert values["eps_L"]["value"] == f"{plain.fit['eps_L']:.4g}"


@given(st.sampled_from(sorted({unit for unit, _ in NAMES.values()})), st.floats(1e-9, 1e12))
def test_exact_text_reads_back_the_same(unit: str, value: float) -> None:
    for number in (value, -value):
        assert units.parse_quantity(exact_text(number, unit), unit) == number


@pytest.mark.parametrize(
    ("value", "unit", "words"),
    [(0.3e-3, "m", "0.3 mm"), (70e-3, "m", "70 mm"), (339.95, "K", "66.8 degC"), (0.45, "1", "0.45")],
)
def test_exact_text_is_no_longer_than_it_must_be(value: float, unit: str, words: str) -> None:
    assert exact_text(value, unit) == words


def test_a_few_digits_are_read_in_a_familiar_unit() -> None:
    assert format_quantity(29.929e9, "Pa") == "29.93 GPa"
    assert format_quantity(336.3445, "K") == "63.19 degC"
    assert format_quantity(0.0374864, "1") == "0.03749"
    assert shown_range((50e6, 200e6), "Pa") == "50 to 200 MPa"
    assert shown_range((-5e8, 2e9), "Pa") == "-0.5 to 2 GPa"
    assert shown_range((150e6, 150e6), "Pa") == "150 MPa"


# ---------------------------------------------------------------- kinds and sources


def test_what_is_not_fitted_keeps_its_kind_and_its_source(plain: Sample) -> None:
    values, first = document(plain)["values"], load_material("flexinol-90")
    for name in ("E_A", "M_s", "C_M", "rho_A", "density", "thermal_conductivity"):
        kept = first.values[name]
        written = values[name]
        assert (written["value"], written["kind"]) == (kept.text, kept.kind)
        assert written.get("note", "") == kept.note
    sources = document(plain)["sources"]
    assert sources["f1140"]["cite"] == "dynalloy-f1140"
    assert set(values) == {n for n in NAMES if n in values}
    assert list(values) == [n for n in NAMES if n in values]


def test_what_the_scenario_changed_is_assumed(plain: Sample) -> None:
    found = document(plain)
    number = found["values"]["heat_capacity"]
    assert (number["value"], number["kind"], number["source"]) == ("500 J/kg/K", "assumed", "scenario")
    assert "A wire in a chamber" in found["sources"]["scenario"]["text"]


def test_without_a_scenario_nothing_else_is_more_than_assumed(plain: Sample) -> None:
    found = document(plain, scenario=None)
    kinds = {name: number["kind"] for name, number in found["values"].items()}
    assert {name for name, kind in kinds.items() if kind == "fitted"} == set(FREE)
    assert set(kinds.values()) == {"fitted", "assumed"}
    assert "rho_A" in kinds and "thermal_conductivity" not in kinds


def test_every_source_is_used_and_in_the_bibliography(plain: Sample, poor: Sample) -> None:
    for one in (plain, poor):
        found = document(one)
        used = {number["source"] for number in found["values"].values()}
        assert used == set(found["sources"])
        assert {source["cite"] for source in found["sources"].values()} <= set(read_bibliography())
    assert document(plain, cite="leal2016")["sources"]["fit"]["cite"] == "leal2016"
    with pytest.raises(InputError, match="nobody2020"):
        document(plain, cite="nobody2020")


def test_a_fit_of_a_fitted_material_keeps_both_sources_apart(plain: Sample) -> None:
    document(plain, "first.toml")
    text = TEXT.replace('"flexinol-90"', f'"{plain.folder / "first.toml"}"')
    again = replace(plain, scenario=read_scenario(text))
    found = document(again, "second.toml")
    assert found["values"]["A_s"]["source"] == "fit"
    assert found["sources"]["fit"]["text"] != ""
    first = load_material(plain.folder / "first.toml")
    assert {k for k in found["sources"] if k.startswith("fit")} == {"fit"}
    assert found["values"]["heat_capacity"]["source"] == "scenario-of-first"
    assert first.values["heat_capacity"].source == "scenario"


# ---------------------------------------------------------------- how far to trust it


def test_intervals_and_bounds_stand_beside_the_numbers(plain: Sample) -> None:
    note = document(plain)["values"]["A_s"]["note"]
    low, high = (end - 273.15 for end in plain.fit.uncertainty.interval("A_s"))
    assert f"{low:.4g} to {high:.4g} degC" in note
    free = plain.fit.problem.free[0]
    assert f"searched from {free.low - 273.15:.4g} to {free.high - 273.15:.4g} degC" in note


def test_bounds_and_idle_parameters_are_named(poor: Sample) -> None:
    found = document(poor)
    values = found["values"]
    assert "ended on a bound" in values["A_s"]["note"]
    assert values["heat_capacity"]["value"] == "500 J/kg/K"  # and not where the search left it
    assert values["heat_capacity"]["kind"] == "assumed"
    assert "without effect" in values["heat_capacity"]["note"]
    assert found["fit"]["free"]["A_s"]["at_bound"] is True
    assert "A_s ended on its upper bound" in found["limits"]
    assert "heat_capacity is not determined" in found["limits"]
    assert "bound" not in document_note("C_A", found)


def document_note(name: str, found: dict[str, Any]) -> str:
    return str(found["values"][name]["note"])


def test_what_every_record_has_for_itself_is_not_fitted(poor: Sample) -> None:
    number = document(poor)["values"]["E_A"]
    assert (number["kind"], number["value"]) == ("assumed", "75 GPa")
    for record in ("light", "middle", "heavy"):
        assert f"{poor.fit[f'E_A@{record}'] / 1e9:.4g} GPa in {record}" in number["note"]


def test_limits_say_where_it_was_fitted_and_how_well(plain: Sample) -> None:
    limits = document(plain)["limits"]
    assert "temperature 20 to 140 degC" in limits
    section = math.pi / 4 * 0.381e-3**2
    ends = [mass * 9.80665 / section / 1e6 for mass in (0.6, 1.6)]
    assert f"stress {ends[0]:.4g} to {ends[1]:.4g} MPa" in limits
    assert "Kept back: kept." in limits


# ---------------------------------------------------------------- provenance


def column_hash(columns: dict[str, list[float]]) -> str:
    total = hashlib.sha256()
    for name, column in columns.items():
        total.update(name.encode() + b"\0" + struct.pack(f"<{len(column)}d", *column))
    return total.hexdigest()


def wrong_hashes(one: Sample, found: dict[str, Any]) -> list[str]:
    """Records whose hash is not that of their file, or of their columns."""
    records = {record["name"]: record for record in found["fit"]["records"]}
    wrong: list[str] = []
    for name, path in one.files.items():
        assert records[name]["file"] == path.name
        if records[name]["sha256"] != hashlib.sha256(path.read_bytes()).hexdigest():
            wrong.append(name)
    (heavy,) = [e for e in one.fit.problem.experiments if e.name == "heavy"]
    if records["heavy"]["sha256_of_columns"] != column_hash(heavy.record.columns):
        wrong.append("heavy")
    return wrong


def test_hashes_are_those_of_the_data(plain: Sample) -> None:
    found = document(plain)
    assert [record["name"] for record in found["fit"]["records"]] == ["light", "middle", "heavy", "kept"]
    assert wrong_hashes(plain, found) == []


def test_other_data_have_another_hash(tmp_path: Path) -> None:
    one = sample(tmp_path)
    found = document(one)
    with one.files["middle"].open("a", encoding="utf-8") as file:
        file.write("# a remark\n")
    assert wrong_hashes(one, found) == ["middle"]


def test_counts_errors_and_bounds_are_those_of_the_fit(plain: Sample) -> None:
    fit = document(plain)["fit"]
    records = {record["name"]: record["outputs"]["strain"] for record in fit["records"]}
    assert records["light"]["training_rows"] == 81
    assert (records["middle"]["training_rows"], records["middle"]["held_out_rows"]) == (70, 11)
    assert (records["heavy"]["training_rows"], records["heavy"]["missing"]) == (77, 4)
    assert "training_rows" not in records["kept"] and records["kept"]["held_out_rows"] == 81
    for score in plain.fit.scores:
        key = f"{score.part.replace('-', '_')}_rms"
        assert records[score.record][key] == f"{100 * score.rms:.3g} %"
    for free in plain.fit.problem.free:
        written = fit["free"][free.name]
        assert units.parse_quantity(written["value"], free.unit) == plain.fit[free.name]
        assert units.parse_quantity(written["low"], free.unit) == pytest.approx(free.low, rel=1e-3)
        assert units.parse_quantity(written["high"], free.unit) == pytest.approx(free.high, rel=1e-3)
    assert (fit["cost"], fit["loss"], fit["method"]) == (plain.fit.cost, "linear", "trf")


def test_the_same_fit_gives_the_same_file_wherever_it_lies(plain: Sample, tmp_path: Path) -> None:
    one, other = tmp_path / "mine.toml", plain.folder / "mine.toml"
    for path in (one, other):
        write_material(plain.fit, path, scenario=plain.scenario)
    text = one.read_text(encoding="utf-8")
    assert text == other.read_text(encoding="utf-8")
    assert str(plain.folder) not in text and str(tmp_path) not in text


def test_published_records_are_cited(plain: Sample) -> None:
    first, *others = plain.fit.problem.experiments
    record = replace(first.record, name="flexinol-isobaric/isobaric_50MPa.txt")
    problem = replace(plain.fit.problem, experiments=(replace(first, record=record), *others))
    found = document(replace(plain, fit=replace(plain.fit, problem=problem)))
    assert found["sources"]["fit"]["cite"] == "leal2016"
    assert document(plain)["sources"]["fit"]["cite"] == "martensite"


# ---------------------------------------------------------------- the law of a material


def test_the_law_is_written_with_all_its_options(plain: Sample) -> None:
    assert document(plain)["law"] == {
        "kind": "liang-rogers",
        "history": "resume",
        "modulus": "mixture",
        "transformation": "strain",
        "hardening": "cosine",
        "surfaces": "straight",
        "compression": "none",
    }


def test_a_scenario_takes_the_law_of_its_material_and_may_change_it(plain: Sample) -> None:
    document(plain)
    text = TEXT.replace('"flexinol-90"', f'"{plain.folder / "mine.toml"}"').replace(LAW, "")
    whole = read_scenario(text)
    assert whole.single_system.element.law.__dict__["modulus"] == "mixture"
    assert whole.remarks == []
    (remark,) = read_scenario(text, None, {"element.law.A_s": "60 degC"}).remarks
    assert "overridden by the scenario: `A_s`" in remark
    changed = read_scenario(text, None, {"element.law.modulus": "austenite"})
    assert changed.single_system.element.law.__dict__["modulus"] == "austenite"
    (remark,) = changed.remarks
    assert "`modulus = austenite`" in remark and "`liang-rogers`" in remark
    (remark,) = read_scenario(text, None, {"element.law": "elahinia"}).cautions[:1]
    assert "`mine` hold for law `liang-rogers`" in remark and "`elahinia`" in remark


def test_check_and_run_say_that_the_law_is_another(plain: Sample, tmp_path: Path) -> None:
    document(plain)
    path, out = tmp_path / "other.toml", tmp_path / "other.nc"
    text = TEXT.replace('"flexinol-90"', f'"{plain.folder / "mine.toml"}"')
    path.write_text(text.replace(LAW, 'law = "tanaka"\n'), encoding="utf-8")
    check, run = Command("check"), Command("run")
    for words in (check.fine(str(path)), run.fine(str(path), "--no-figure", "--out", str(out))):
        shown = " ".join(words.split())
        assert "Caution: The numbers of material `mine` hold for law" in shown
        assert "but law `tanaka` is used here" in shown


def test_the_law_command_takes_the_options_of_the_material(plain: Sample) -> None:
    document(plain)
    path = str(plain.folder / "mine.toml")
    own, other = configure_laws(["liang-rogers", "tanaka"], path, {})
    assert law_words(own.law)["modulus"] == "mixture"
    assert not any("hold for law" in words for words in own.cautions)
    assert "hold for law `liang-rogers`" in other.cautions[0]
    assert "Law: liang-rogers, history = resume" in Command("materials").fine(path)


def test_numbers_of_a_law_without_a_canonical_name_go_with_it(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    first = load_material("finger-mas")
    lines = [f'{n} = {{ value = "{v.text}", kind = "assumed", source = "a" }}' for n, v in first.values.items()]
    path.write_text(
        '[law]\nkind = "mas-polycrystal"\nspread = "33 MPa"\n'
        '[sources.a]\ncite = "martensite"\ntext = "t"\n[values]\n' + "\n".join(lines),
        encoding="utf-8",
    )
    text = TEXT.replace('"flexinol-90"', f'"{path}"').replace(LAW, "")
    text = text.replace(
        'kind = "wire"', 'kind = "wire"\nresistance = { kind = "per-length", r_A = "8 ohm/m", r_M = "9 ohm/m" }'
    )
    found = read_scenario(text)
    law = found.single_system.element.law
    assert law.registered_name == "mas-polycrystal" and law.value_of("spread") == 33e6
    assert found.origins["element.law.spread"] == "law, mine"
    assert found.origins["element.law.eps_T"] == "assumed, mine"


@pytest.mark.parametrize(
    "law, expected",
    [
        ("law = 3", "must be a table"),
        ("[law]\nhistory = 'resume'", "needs `kind`"),
        ("fit = 'good'", "must be a table"),
        ("[laws]\nkind = 'x'", "Did you mean `law`"),
    ],
)
def test_a_malformed_law_is_refused(tmp_path: Path, law: str, expected: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(law, encoding="utf-8")
    with pytest.raises(InputError, match=expected):
        load_material(path)


# ---------------------------------------------------------------- refusals


def test_no_file_is_left_where_none_can_be_written(plain: Sample, tmp_path: Path) -> None:
    for path, words in (("mine.json", r"ends in \.toml"), ("no/mine.toml", "does not exist")):
        with pytest.raises(InputError, match=words):
            write_material(plain.fit, tmp_path / path, scenario=plain.scenario)
    with pytest.raises(InputError, match="port"):
        write_material(plain.fit, tmp_path / "mine.toml", port="left")
    assert list(tmp_path.iterdir()) == []


def two_wires(law: LiangRogers) -> Machine:
    """Two wires that pull against each other, the second with a law of its own."""
    parts = [
        Actuator(element=e.element, environment=e.environment, source=e.source)
        for e in (plain_system(), plain_system(law))
    ]
    pulley = AntagonisticPulley(radius=0.01, preload=10.0)
    return Machine(mechanism=pulley, group=Group(**dict(zip(pulley.ports(), parts, strict=True))))


def test_actuators_that_differ_are_no_single_material() -> None:
    same, other = two_wires(plain_law()), two_wires(plain_law(eps_L=0.035))
    ports = list(same.actuators())
    assert name_canonically([same])["eps_L"].value == 0.04
    with pytest.raises(InputError, match=r"`eps_L` \(0\.04 and 0\.035\)"):
        name_canonically([other])
    assert [name_canonically([other], port)["eps_L"].value for port in ports] == [0.04, 0.035]


def test_laws_that_differ_are_no_single_material() -> None:
    other = two_wires(LiangRogers(**PLAIN_LAW, history="restart"))
    ports = list(other.actuators())
    with pytest.raises(InputError, match="different laws, or one law with different options"):
        find_law([other])
    found = [law_words(find_law([other], port))["history"] for port in ports]
    assert found == ["resume", "restart"]


def test_records_that_differ_are_no_single_material() -> None:
    systems = [plain_system(), plain_system(plain_law(E_A=60e9))]
    with pytest.raises(InputError, match=r"systems of the records differ in `E_A`"):
        name_canonically(systems)
    assert name_canonically(systems, None, lambda path: path.endswith("E_A"))["E_A"].value == 75e9
