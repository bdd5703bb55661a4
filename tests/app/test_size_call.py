"""Sizing as the page asks for it: the form, the wires with margins and scenarios, the check."""

from pathlib import Path
from typing import Any

import pytest
from app_server import Bench
from typescript import check_answer

from martensite.app.calls import size_map, sizing
from martensite.app.calls.sizing import EXAMPLE
from martensite.app.messages import BadMessageError
from martensite.app.worker import Desk
from martensite.base.errors import InputError
from martensite.design.sizing.candidates import judge_candidate, size_wire
from martensite.design.sizing.remarks import find_tightest, list_margins
from martensite.design.sizing.request import WireRequest
from martensite.scenario.exact_text import convert_to_plain
from martensite.scenario.scenario import read_scenario

SMALL = {"force": "0.5 N", "stroke": "3 mm", "rate": "0.2 Hz", "supply": "5 V", "alloy": "90"}


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Desk:
    return Desk(tmp_path_factory.mktemp("size"))


@pytest.fixture(scope="module")
def notes() -> list[dict[str, Any]]:
    return []


@pytest.fixture(scope="module")
def found(desk: Desk, notes: list[dict[str, Any]]) -> dict[str, Any]:
    telling = Desk(desk.folder, lambda note: notes.append(dict(note)))
    answer = sizing.size_wires({"fields": SMALL}, telling)
    check_answer(answer, "size", "Sizing")
    return convert_to_plain(answer)


def formed(desk: Desk, **fields: str) -> dict[str, Any]:
    return sizing.describe_sizing({"fields": fields}, desk)


# ---------------------------------------------------------------- the form


def test_the_form_is_that_of_the_declarations(bench: Bench) -> None:
    form = bench.call("size_form", {})
    assert [field["name"] for field in form["fields"]] == list(WireRequest.declarations)
    needed = [field["name"] for field in form["fields"] if field["required"]]
    assert needed == ["force", "stroke", "rate", "supply"]
    assert {field["name"]: field["default"] for field in form["fields"]}["ambient"] == "22 degC"


def test_any_unit_of_the_quantity_is_read(desk: Desk) -> None:
    form = formed(desk, force="0.5 kgf", ambient="295 K", strain="3.5 %", bias="weight")
    assert form["refused"] == {} and form["contradiction"] == "" and form["unknown"] == []


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("force", "8", "`8` has no unit; write for example `8 N`."),
        ("force", "8 mm", "cannot be converted to `N`"),
        ("force", "much", "is not a number with a unit"),
        ("force", "-8 N", "must be above 0 N"),
        ("strain", "40 %", "between 0.002 and 0.08"),
        ("alloy", "80", "Valid: `70`, `90`, `any`."),
    ],
)
def test_a_field_is_refused_by_itself(desk: Desk, name: str, text: str, sentence: str) -> None:
    form = formed(desk, stroke="3 mm", **{name: text})
    assert list(form["refused"]) == [name]
    assert sentence in form["refused"][name]


def test_fields_that_contradict_each_other_are_told(desk: Desk) -> None:
    assert "the return of the wire takes" in formed(desk, stress="60 MPa")["contradiction"]


def test_fields_of_an_old_link_are_named(desk: Desk) -> None:
    assert formed(desk, length="3 mm", force="8 N")["unknown"] == ["length"]


@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        ({"force": "8 N"}, "Fill in `stroke`, `rate`, `supply` first."),
        ({**SMALL, "force": "8"}, "has no unit"),
        ({**SMALL, "length": "8 mm"}, "A sizing has no field `length`"),
        ({**SMALL, "force": 8}, "`force` must be text"),
        ({**SMALL, "force": "8" * 300}, "more than 200 letters"),
        ({**SMALL, "stress": "60 MPa"}, "the return of the wire takes"),
    ],
)
def test_a_wrong_request_is_refused(desk: Desk, fields: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        sizing.size_wires({"fields": fields}, desk)


def test_fields_must_be_a_table(desk: Desk) -> None:
    with pytest.raises(BadMessageError, match="`fields` must be a table"):
        sizing.describe_sizing({"fields": []}, desk)


# ---------------------------------------------------------------- the wires


def test_the_wires_are_those_of_the_library(found: dict[str, Any]) -> None:
    request = WireRequest(force=0.5, stroke=3e-3, rate=0.2, supply=5.0, alloy="90")
    direct = size_wire(request)
    assert [one["size"] for one in found["candidates"]] == [one.size.name for one in direct.candidates]
    best = found["candidates"][0]
    assert best["feasible"] and best["cells"][0] == "1"
    assert best["drive"]["energy"] == pytest.approx(direct.candidates[0].drive.energy)  # type: ignore[union-attr]
    assert any("Return spring" in sentence for sentence in best["sentences"])
    assert len(found["columns"]) == len(best["cells"])


def test_progress_counts_to_the_end(found: dict[str, Any], notes: list[dict[str, Any]]) -> None:
    assert notes == [{"done": k, "of": 12} for k in range(13)]
    assert found["of"] == len(found["candidates"]) == 12


def test_a_stopped_sizing_answers_with_what_it_has(desk: Desk) -> None:
    stopped = Desk(desk.folder)

    def tell(note: Any) -> None:
        if note["done"] == 2:
            stopped.stop.set()

    stopped.tell = tell
    answer = sizing.size_wires({"fields": SMALL}, stopped)
    assert len(answer["candidates"]) == 2 and answer["of"] == 12


def test_scenarios_run_at_the_stroke_asked_for(found: dict[str, Any], tmp_path: Path) -> None:
    result = read_scenario(found["candidates"][0]["scenario"], tmp_path / "wire.toml").run()
    assert result.stroke == pytest.approx(3e-3, rel=0.05)
    for one in found["candidates"]:
        assert (one["scenario"] is None) == bool(one["no_scenario"])


def test_margins_say_what_fails(found: dict[str, Any]) -> None:
    for one in found["candidates"]:
        over = [m["name"] for m in one["margins"] if m["share"] > 1.0 + 1e-6]
        assert not (one["feasible"] and over), one["size"]
    slow = [one for one in found["candidates"] if "too slow" in " ".join(one["reasons"])]
    assert slow
    assert all(one["tightest"]["name"] == "time of a cycle" for one in slow)
    assert all(one["tightest"]["share"] > 1.0 for one in slow)


def test_a_margin_is_used_over_limit() -> None:
    request = WireRequest(force=0.5, stroke=3e-3, rate=0.2, supply=5.0, current_limit=1.0)
    candidate = judge_candidate(request, size_wire_sizes()["0.10 mm"], "90")
    named = {margin.name: margin for margin in list_margins(request, candidate)}
    drive = candidate.drive
    assert drive is not None
    assert named["current"].share == pytest.approx(drive.current / 1.0)
    assert named["voltage"].share == pytest.approx(drive.voltage / 5.0)
    assert named["stress"].share == pytest.approx(candidate.statics.hot_stress / 172e6)
    assert named["strain"].share == 1.0 and named["strain"].chosen
    assert not find_tightest(list(named.values())).chosen


def size_wire_sizes() -> Any:
    from martensite.physics.materials.wires import load_wires

    return load_wires().sizes


def test_the_example_has_wires_that_do() -> None:
    request = WireRequest(force=8.0, stroke=5e-3, rate=0.05, supply=12.0)
    assert EXAMPLE == {"force": "8 N", "stroke": "5 mm", "rate": "0.05 Hz", "supply": "12 V"}
    assert judge_candidate(request, size_wire_sizes()["0.20 mm"], "70").feasible


# ---------------------------------------------------------------- the check of the catalogue


def test_the_check_takes_only_its_conditions(desk: Desk) -> None:
    stopped = Desk(desk.folder)
    stopped.tell = lambda note: stopped.stop.set()
    answer = sizing.compare_catalogue({"fields": {**SMALL, "ambient": "30 degC", "stress": "150 MPa"}}, stopped)
    assert answer["asked"] == {"alloy": "90", "ambient": "30 degC", "stress": "150 MPa"}
    assert "150 MPa" in answer["conditions"] and "30 °C" in answer["conditions"]
    (row,) = answer["rows"]
    assert len(row) == len(answer["columns"]) and row[1] == "90"
    with pytest.raises(InputError, match="has no unit"):
        sizing.compare_catalogue({"fields": {"stress": "150"}}, desk)


# ---------------------------------------------------------------- the map, and the loop


def test_the_map_is_that_of_the_sizings(desk: Desk, found: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(size_map, "FORCES", 3)
    monkeypatch.setattr(size_map, "STROKES", 1)
    monkeypatch.setattr(size_map, "list_levels", lambda middle, count: [middle, 80.0 * middle, 1.2 * middle][:count])
    told: list[dict[str, Any]] = []
    asked = {"fields": SMALL | {"strands": "1"}}
    answer = size_map.map_wishes(asked, Desk(desk.folder, lambda note: told.append(dict(note))))
    check_answer(answer, "size", "Mapped")
    cells = {cell["column"]: cell for cell in answer["cells"]}
    alone = sizing.size_wires(asked, desk)["candidates"]
    assert cells[0]["does"] == sum(one["feasible"] for one in alone)
    assert cells[0]["robust"] == sum(one["feasible"] and not one["frail"] for one in alone)
    assert cells[0]["best"]["size"] == alone[0]["size"]
    assert cells[1]["best"] is None and cells[1]["reason"]
    assert [note["done"] for note in told] == [0, 1, 2, 3] and told[1]["cell"][
        "column"
    ] == 1  # the wish is in the middle


def test_a_wire_that_was_found_moves_in_a_loop(found: dict[str, Any]) -> None:
    scenario = read_scenario(found["candidates"][0]["loop"])
    result = scenario.run()
    reached = max(result["position"])
    assert reached == pytest.approx(0.9 * 3e-3, rel=0.03)
    assert not result.status.failed and result.alarms == []
    assert scenario.bench is not None
