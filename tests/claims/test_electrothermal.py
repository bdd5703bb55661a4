"""Study `electrothermal-staircase`: with the record, and without it.

Numbers of the record were found for this project by numpy on the plain text of the files,
code not shared with the study; they are given to the digits noted.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
from claim_checks import check_complete, check_decides, check_shipped, numbers_of, verdicts_of

from martensite.base.errors import DataError
from martensite.logs import datasets
from martensite.logs.reader import read_table
from martensite.scenario.citations import read_bibliography
from martensite.scenario.scenario import load
from martensite.studies.base import AbstractStudy, Answer, load_study, study_names
from martensite.studies.electrothermal import model, record, record_numbers, resistance_figure
from martensite.studies.electrothermal.model_numbers import KEPT, calibrate_numbers
from martensite.studies.electrothermal.record import RecordStaircase
from martensite.studies.tables import printed_numbers

NAME = "electrothermal-staircase"
STATED = printed_numbers("electrothermal")
FILES = (record.UNTRAINED, record.WARMTH, record.TRAINED)
EXAMPLE = Path(__file__).parents[2] / "examples" / "flexinol_staircase.toml"
HERE = record.has_files(*FILES)
needs_record = pytest.mark.skipif(not HERE, reason=f"data set {record.DATA} is not on this machine")
VERDICTS = {
    "disagrees": {"counter", "trained-offset", "sheet-martensite", "sheet-austenite"},
    "not comparable": {"offset"},
    "recovery": {"film", "calibrated-start", "calibrated-end"},
}
NEEDLESS = {"maker-martensite", "maker-austenite", "maker-start", "maker-end", "film-horizontal", "film-vertical"}
"""Reports that need no record."""


@pytest.fixture(scope="module")
def study() -> AbstractStudy:
    return load_study(NAME)


@pytest.fixture(scope="module")
def answer(study: AbstractStudy) -> Answer:
    return study.compute()


@pytest.fixture
def without(monkeypatch, tmp_path) -> None:
    """A machine without the data."""
    monkeypatch.setenv(datasets.VARIABLE, str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


# ---------------------------------------------------------------- claims


def test_every_claim_is_complete(answer: Answer) -> None:
    check_complete(answer, all_computed=False)
    assert NAME in study_names()
    assert set(load_study(NAME).cites) <= set(read_bibliography())


@needs_record
def test_verdicts(answer: Answer) -> None:
    assert verdicts_of(answer.claims) == VERDICTS
    check_decides(claim for claim in answer.claims if claim.tolerance)
    assert all(number is not None for number in numbers_of([answer]).values())


def test_what_ships_is_what_is_computed(study: AbstractStudy) -> None:
    check_shipped(study)


@needs_record
def test_the_record_has_what_the_material_says_of_it(answer: Answer) -> None:
    """The material's numbers were read off this record: to the last digit stated, and the fits within its margins."""
    found = numbers_of([answer])
    for id, stated, margin in (
        ("martensite-low", STATED.martensite_low, 0.01),
        ("martensite-high", STATED.martensite_high, 0.01),
        ("austenite", STATED.austenite, 0.01),
        ("drop-start", STATED.drop_start, 0.02),
        ("drop-end", STATED.drop_end, 0.02),
        ("fit-rho-austenite", 1e8 * STATED.rho_A, 2.0),
        ("fit-rho-martensite", 1e8 * STATED.rho_M, 4.0),
        ("fit-difference-slopes", 1e8 * (STATED.rho_M - STATED.rho_A), 2.3),
    ):
        assert found[id] == pytest.approx(stated, abs=margin), id


def test_claims_without_the_record_say_how_to_get_it(without) -> None:
    found = load_study(NAME).compute()
    absent = [one for one in (*found.claims, *found.reports) if one.computed is None]
    assert {claim.verdict for claim in found.claims} == {"not comparable"}
    assert all("martensite data fetch flexinol-electrothermal" in one.why for one in absent)
    assert {one.id for one in found.reports if one.computed is not None} == NEEDLESS
    assert "…" in found.digest["holds"]
    shipped = load_study(NAME).load_shipped_answer()
    assert shipped is not None and verdicts_of(shipped.claims) == VERDICTS  # what ships is shown all the same
    with pytest.raises(DataError, match="not on this machine; run `martensite data fetch"):
        read_table(f"data:{record.UNTRAINED}")


def test_a_file_that_is_not_the_one_listed_is_an_error(without, tmp_path) -> None:
    folder = tmp_path / record.DATA
    folder.mkdir()
    for file in FILES:
        (folder / file.partition("/")[2]).write_text("1000.00 5.0\n")
    with pytest.raises(DataError, match="is not the file that data set"):
        record.trained_slopes((2.5, 3.5), (4.4, 5.4))


# ---------------------------------------------------------------- the record


@needs_record
def test_record() -> None:
    run = RecordStaircase(STATED)
    raw = read_table(f"data:{record.UNTRAINED}")
    assert (len(raw), raw.dropped) == (1068, 9)
    table = run.table
    assert table["set_point"] == pytest.approx([1.0 + 0.1 * k for k in range(36)])
    assert table["current"][12] == pytest.approx(1.2422, abs=2e-4)
    assert table["current"][20] == pytest.approx(1.9830, abs=2e-4)
    assert run.resistance[12] == pytest.approx(1.5855, abs=2e-4)
    assert run.mean(*STATED.cold) == pytest.approx(1.5335, abs=1e-4)
    assert run.mean(*STATED.hot) == pytest.approx(1.4036, abs=1e-4)
    assert table["apparent_temperature"][12] - 273.15 == pytest.approx(65.4, abs=0.3)
    assert table["apparent_temperature"][-1] - 273.15 == pytest.approx(144.1, abs=0.5)
    assert run.jumps() == 0


@needs_record
def test_the_drop_and_the_offset() -> None:
    run = RecordStaircase(STATED)
    assert run.drop() == pytest.approx((1.2422, 1.6931), abs=2e-4)
    assert run.drop()[0] < run.half_way() < run.drop()[1]
    assert run.half_way() == pytest.approx(1.432, abs=1e-3)
    offset = run.offset(*STATED.cold)
    assert (offset.offset, offset.offset_error) == pytest.approx((0.178, 0.057), abs=6e-4)
    assert offset.count == 10
    mild, steep = record.trained_slopes(record_numbers.MILD, record_numbers.STEEP)
    assert mild.resistance == pytest.approx(1.657, abs=1e-3)
    assert steep.resistance == pytest.approx(0.944, abs=1e-3)


@needs_record
def test_the_wire_warms_when_the_current_comes() -> None:
    camera = read_table(f"data:{record.WARMTH}")
    pairs = zip(camera.times, camera["apparent_temperature"], strict=True)
    after = [(t - record.LATER, kelvin) for t, kelvin in pairs if t > record.LATER - 60.0]
    cold = [kelvin for t, kelvin in after if t < -20.0]
    before = sum(cold) / len(cold)
    assert before - 273.15 == pytest.approx(25.6, abs=0.05)
    assert before == pytest.approx(model.read_number("environment.temperature"), abs=0.05)
    warm = next(t for t, kelvin in after if kelvin > max(cold) + 0.3)
    assert abs(warm) < 10.0


# ---------------------------------------------------------------- the model


def test_scenario_says_what_is_stated() -> None:
    wire, waveform = model.get_wire(), model.load_scenario().single_waveform
    assert wire.diameter == pytest.approx(STATED.diameter)
    assert wire.length == pytest.approx(STATED.length)
    assert waveform.value(0.0) == pytest.approx(1.0 - STATED.offset, abs=1e-3)
    assert waveform.value(1151.0) == pytest.approx(4.5 - STATED.offset, abs=1e-3)


def test_plateaus_of_the_model_are_steady_states() -> None:
    """I²R = h S (T - T_a) and V = R I on every plateau of austenite."""
    table = model.predict_plateaus("material", STATED)
    environment = model.load_scenario().single_system.environment
    surface = math.pi * STATED.diameter * STATED.length
    for i, current in enumerate(table["current"]):
        resistance, temperature = table["resistance"][i], table["temperature"][i]
        if table["drive"][i] < 1.1:
            continue  # transforming, and still warming
        assert table["drive"][i] == pytest.approx(resistance * current, rel=1e-5)
        h = model.film_coefficient(environment.cooling, temperature)
        lost = h * surface * (temperature - model.read_number("environment.temperature"))
        assert current**2 * resistance == pytest.approx(lost, rel=0.012)
    assert sum(volt >= 1.1 for volt in table["drive"]) == 32


@needs_record
def test_differences() -> None:
    run, fitted = RecordStaircase(STATED), calibrate_numbers(STATED)
    assert fitted.rho_A == pytest.approx(8.42e-7, rel=1e-3)
    assert fitted.rho_M == pytest.approx(9.20e-7, rel=1e-3)
    found = {
        key: model.resistance_rms(model.predict_plateaus(key, STATED, fitted), run, *KEPT) for key in model.VARIANTS
    }
    assert found["calibrated"] < found["material"] < found["maker"]
    level = [run.mean(*span) for span in (STATED.cold, STATED.hot)]
    pairs = zip(run.table["set_point"], run.resistance, strict=True)
    steps = [r - level[0 if v < 2.25 else 1] for v, r in pairs if v > 1.25]
    flat = math.sqrt(sum(x * x for x in steps) / len(steps))
    assert found["calibrated"] < flat
    wrong = replace(fitted, h=0.5 * fitted.h)
    assert model.resistance_rms(model.predict_plateaus("calibrated", STATED, wrong), run, *KEPT) > flat


@needs_record
def test_half_of_the_drop_lies_where_it_was_put() -> None:
    fitted = calibrate_numbers(STATED)
    surface = math.pi * STATED.diameter * STATED.length
    mean = 0.5 * (fitted.rho_A + fitted.rho_M) * STATED.length / model.get_wire().section()
    power = RecordStaircase(STATED).half_way() ** 2 * mean
    warmer = power / (fitted.h * surface)
    ambient = model.read_number("environment.temperature")
    assert ambient + warmer == pytest.approx(model.half_way_temperature(), abs=1e-9)
    table = model.predict_plateaus("calibrated", STATED, fitted)
    fractions = table["martensite_fraction"]
    at = next(i for i, xi in enumerate(fractions) if xi < 0.5)
    assert table["current"][at - 1] < RecordStaircase(STATED).half_way() < table["current"][at]


@needs_record
def test_example_has_the_calibrated_numbers() -> None:
    fitted = calibrate_numbers(STATED)
    leaves = {leaf.path: leaf.value for leaf in load(EXAMPLE).system.leaves()}
    found = {
        name: next(v for path, v in leaves.items() if path.endswith(name)) for name in ("rho_A", "rho_M", "cooling.h")
    }
    assert found["rho_A"] == pytest.approx(fitted.rho_A, rel=1e-3)
    assert found["rho_M"] == pytest.approx(fitted.rho_M, rel=1e-3)
    assert found["cooling.h"] == pytest.approx(fitted.h, rel=2e-3)


def test_example_loads_without_the_record(without) -> None:
    scenario, study = load(EXAMPLE), model.load_scenario()
    assert scenario.waveform == study.waveform
    ours = {leaf.path: leaf.value for leaf in scenario.system.leaves()}
    theirs = {leaf.path: leaf.value for leaf in study.system.leaves()}
    shared = {path for path in ours if "rho_" not in path and "cooling" not in path}
    assert len(shared) > 20
    assert all(ours[path] == theirs[path] for path in shared)


# ---------------------------------------------------------------- what is written


def test_figure_without_the_record(without, tmp_path) -> None:
    load_study(NAME).figure(tmp_path / "alone.png")
    assert (tmp_path / "alone.png").read_bytes().startswith(b"\x89PNG")


@needs_record
def test_figure(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(resistance_figure, "_OFFSETS", (0.16, 0.24))
    load_study(NAME).figure(tmp_path / "both.png")
    assert (tmp_path / "both.png").read_bytes().startswith(b"\x89PNG")


@needs_record
def test_readme_has_the_computed_numbers() -> None:
    text = model.SCENARIO.with_name("README.md").read_text(encoding="utf-8")
    run, fitted = RecordStaircase(STATED), calibrate_numbers(STATED)
    for key in model.VARIANTS:
        table = model.predict_plateaus(key, STATED, fitted if key == "calibrated" else None)
        start, end = model.find_span(table)
        row = f"| {model.resistance_rms(table, run, *KEPT):.3f} Ω | {start:.2f} to {end:.2f} A |"
        assert row in text
    assert f"calibrated h is {fitted.h:.0f} W/(m² K)" in text
    horizontal, vertical = model.free_films()
    assert f"{horizontal:.0f} (horizontal" in text and f"{vertical:.0f} (vertical" in text
    hottest = model.predict_plateaus("calibrated", STATED, fitted)["temperature"][-1] - 273.15
    camera = run.table["apparent_temperature"][-1] - 273.15
    assert f"reach {hottest:.0f} °C at 4.5 V, but the camera reads {camera:.0f} °C" in " ".join(text.split())
    for span in (STATED.cold, record_numbers.SHORTER, record_numbers.ALL_COLD):
        found = run.offset(*span)
        assert f"{found.offset:.2f} ± {found.offset_error:.2f} V" in text
