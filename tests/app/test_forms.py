"""Forms of the bench: what they show is what the scenario holds, and what they write is that."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from app_server import Bench
from typescript import check_answer

from martensite.app.calls.form import build_form as answer
from martensite.app.documents import FOLDER, list_standalone
from martensite.app.forms import controls, documents
from martensite.app.worker import Desk
from martensite.base import units
from martensite.base.errors import InputError, UnknownNameError
from martensite.base.files import toml_document
from martensite.base.formats import spell_symbol
from martensite.base.parameters import FieldDeclaration, Number, param
from martensite.physics.laws.base import LAWS
from martensite.physics.laws.strip_laws import LiangRogers
from martensite.scenario.scenario import read_scenario

TEXT = list_standalone()["constant_power"]
DESK = Desk(Path())
E_A = "element.law.E_A"


def form(text: str = TEXT, **request: Any) -> Any:
    return answer({"text": text, **request}, DESK)


def flat(items: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    for item in items:
        yield item
        yield from flat(item.get("items", []))


def control(found: dict[str, Any], path: str) -> dict[str, Any]:
    (one,) = [item for item in flat(found["sections"]) if item["path"] == path]
    return one


def numbers(found: dict[str, Any]) -> list[dict[str, Any]]:
    return [item for item in flat(found["sections"]) if item["sort"] == "number"]


# ---------------------------------------------------------------- what is shown


def test_a_form_comes_over_the_interface(bench: Bench) -> None:
    found = bench.call("form", {"text": TEXT, "changes": {"element.diameter": "0.25 mm"}})
    assert "error" not in found, found
    assert 'diameter = "0.25 mm"' in found["text"]
    one = control(found, "element.diameter")
    assert one["value"] == pytest.approx(0.25e-3)
    assert one["value"] * one["factor"] + one["offset"] == pytest.approx(0.25)
    assert (one["display_unit"], one["title"], one["required"]) == ("mm", "diameter", True)
    assert {choice["name"] for choice in found["registries"]["law"]} == set(LAWS.names())


def test_numbers_of_the_material_come_with_their_source() -> None:
    one = control(form(), E_A)
    assert one["origin"]["sort"] == "material"
    assert (one["origin"]["kind"], one["origin"]["doubtful"]) == ("datasheet", False)
    assert "data table" in one["origin"]["source"]
    assert (one["display_unit"], one["symbol"], one["changed"]) == ("GPa", "E_A", False)
    assert control(form(), "element.law.A_s")["origin"]["doubtful"]


def test_what_goes_over_the_material_can_be_taken_back() -> None:
    changed = form(changes={E_A: "61 GPa"})
    one = control(changed, E_A)
    assert one["changed"] and one["material"]["text"] == "75 GPa"
    back = form(changed["text"], removed=[E_A])
    assert control(back, E_A)["value"] == 75e9
    assert documents.find_entry(toml_document(back["text"]), E_A) is None


@pytest.mark.parametrize("name", list_standalone())
def test_writing_what_a_form_shows_changes_nothing(name: str) -> None:
    """Every number is written at its path, in its unit, and the scenario is the same."""
    text = list_standalone()[name]
    found = form(text)
    shown = [one for one in numbers(found) if one["value"] is not None]
    written = {one["path"]: _written(one) for one in shown if math.isfinite(one["value"])}
    assert len({one["path"] for one in shown}) == len(shown)
    before, after = (read_scenario(text, FOLDER / "x.toml"), read_scenario(text, FOLDER / "x.toml", written))
    pairs = zip(before.leaves(), after.leaves(), strict=True)
    for one, other in pairs:
        assert one.path == other.path
        assert one.value == pytest.approx(other.value, rel=1e-9, abs=1e-300), one.path


def _written(one: dict[str, Any]) -> Any:
    """A number as the page sends it."""
    shown = one["value"] * one["factor"] + one["offset"]
    return f"{shown!r} {one['display_unit']}" if one["display_unit"] else shown


def test_every_number_of_the_system_has_a_control() -> None:
    for name in ("constant_power", "clamped_wire", "platform_spring", "finger", "closed_loop"):
        scenario = read_scenario(list_standalone()[name], FOLDER / "x.toml")
        paths = {one["path"] for one in numbers(form(list_standalone()[name]))}
        known = {scenario.places.path(leaf.path) for leaf in scenario.leaves()}
        assert known <= paths, known - paths


def test_what_ports_have_for_themselves_stands_apart() -> None:
    found = form(list_standalone()["hand"])
    one = control(found, "actuators.thumb_proximal_extensor.element.strand.initial_oriented")
    assert one["value"] == 0.0
    assert control(found, "element.strand.initial_oriented")["value"] == 1.0
    assert control(found, "actuators.index_distal_flexor.drive.waveform.at")["value"] == 3.0


def test_sliders_hold_the_value_and_stay_in_bounds() -> None:
    for name, text in list_standalone().items():
        for one in numbers(form(text)):
            slider = one["slider"]
            if slider is None:
                assert one["unlimited"], (name, one["path"])
                continue
            assert slider["low"] <= one["value"] <= slider["high"], (name, one["path"])
            assert slider["low"] < slider["high"]
            assert one["low"] is None or slider["low"] >= one["low"]
            assert one["high"] is None or slider["high"] <= one["high"]
            assert not slider["log"] or slider["low"] > 0.0


def test_ranges_follow_the_declaration() -> None:
    length = FieldDeclaration("parameter", "length", 1.0, "m", 0.0, 20.0, open_low=True)
    assert controls.build_slider(0.1, length) == {
        "low": pytest.approx(0.01),
        "high": pytest.approx(1.0),
        "log": True,
        "whole": False,
    }
    share = FieldDeclaration("parameter", "share", 1.0, "1", 0.0, 1.0)
    assert controls.build_slider(0.3, share) == {"low": 0.0, "high": 1.0, "log": False, "whole": False}
    count = FieldDeclaration("parameter", "number of elements", 1.0, "1", 1.0, 1e4)
    assert (controls.build_slider(2.0, count) or {})["whole"]
    assert controls.build_slider(math.inf, FieldDeclaration("parameter", "end", math.inf, "s")) is None


@pytest.mark.parametrize(
    ("name", "symbol"),
    [
        ("E_A", "E_A"),
        ("eps_L", "ε_L"),
        ("dsigma_dT", "dσ/dT"),
        ("Delta_sigma", "Δσ"),
        ("h", "h"),
        ("a_rho_A", "a_ρ,A"),
        ("Kp", "K_p"),
        ("h0", "h_0"),
        ("rho_inf", "ρ_∞"),
        ("diameter", ""),
        ("at", ""),
        ("mass_2", ""),
    ],
)
def test_symbols_are_spelled_by_names(name: str, symbol: str) -> None:
    assert spell_symbol(name) == symbol


@pytest.mark.parametrize(
    ("unit", "label"),
    [
        ("W/m^2/K", "W/(m²·K)"),
        ("K", "°C"),
        ("ohm*m", "Ω·m"),
        ("1", ""),
        ("delta_degC", "K"),
        ("m", "mm"),
        ("K/s^0.5", "K/s^½"),
    ],
)
def test_units_are_shown_as_they_are_read(unit: str, label: str) -> None:
    how = controls.describe_display(unit)
    assert how["label"] == label
    assert 300.0 * how["factor"] + how["offset"] == pytest.approx(
        units.from_si(300.0, units.choose_readable_unit(unit), unit)
    )


# ---------------------------------------------------------------- kinds


def test_another_kind_keeps_what_it_knows() -> None:
    found = form(changes={"drive.waveform.kind": "sine"})
    wave = toml_document(found["text"])["drive"]["waveform"]
    assert wave == {"kind": "sine", "high": "0.45 W", "frequency": "0.1 Hz"}
    assert found["assumed"] == ["drive.waveform.frequency"]
    assert "no data" in control(found, "drive.waveform.frequency")["origin"]["words"]


def test_a_wire_is_taken_into_a_bundle_and_out_again() -> None:
    before = toml_document(TEXT)["element"]
    bundle = form(changes={"element.kind": "bundle"})
    table = toml_document(bundle["text"])["element"]
    assert table["strand"] == {k: v for k, v in before.items() if k != "material"}
    back = form(bundle["text"], changes={"element.kind": "wire"})
    after = toml_document(back["text"])["element"]
    assert {**after, "law": "liang-rogers"} == {**before, "law": "liang-rogers"}


def test_a_source_of_another_unit_gets_levels_in_it() -> None:
    found = form(changes={"drive.kind": "voltage"})
    drive = toml_document(found["text"])["drive"]
    assert drive["waveform"]["high"].endswith(" V")
    assert (drive["waveform"]["at"], drive["series_resistance"]) == ("0.5 s", "0.5 ohm")
    assert any("start values" in note for note in found["notes"])


def test_a_mechanism_of_many_parts_brings_its_example_and_says_so() -> None:
    found = form(changes={"mechanism.kind": "hand"})
    assert toml_document(found["text"]) == toml_document(list_standalone()["hand"])
    assert any("packaged scenario" in note for note in found["notes"])
    back = form(found["text"], changes={"mechanism.kind": "dead-weight"})
    assert "actuators" not in toml_document(back["text"])
    assert any("[actuators]" in note for note in back["notes"])


def test_a_material_that_the_law_cannot_use_brings_one_that_it_can() -> None:
    found = form(changes={"element.material": "finger-mas"})
    assert toml_document(found["text"])["element"]["law"]["kind"] == "mas-hybrid"
    assert found["assumed"] == []


@pytest.fixture
def foreign() -> Iterator[str]:
    """A law from elsewhere, with a number that nothing is known of."""

    @LAWS.register("foreign-law")
    class Foreign(LiangRogers):
        """A law from elsewhere."""

        zeta: Number = param("Pa/K", "a number of its own", above=0.0, high=1e9)

    yield "foreign-law"
    del LAWS._entries["foreign-law"]
    assert Foreign.registered_name == "foreign-law"


def test_a_kind_without_start_values_asks_for_its_numbers(foreign: str) -> None:
    changes: dict[str, Any] = {"element.law.kind": foreign}
    found = form(changes=changes)
    assert found["text"] is None
    assert "`zeta` (a number of its own)" in found["refused"]
    check_answer(found, "form", "ScenarioForm")  # with the sections of the scenario as it was
    assert found["sections"] == form()["sections"]
    (one,) = found["missing"]
    assert (one["path"], one["value"], one["display_unit"]) == ("element.law.zeta", None, "MPa/K")
    assert one["allowed"] == "above 0 MPa/K and at most 1000 MPa/K"
    given = form(changes={**changes, one["path"]: "3 MPa/K"})
    assert control(given, "element.law.zeta")["value"] == pytest.approx(3e6)
    with pytest.raises(InputError, match="cannot be converted"):
        form(changes={**changes, one["path"]: "3 mm"})


# ---------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("request_", "words_"),
    [
        ({"text": "x = "}, "not valid TOML"),
        ({"text": 3}, "`text` must be text"),
        ({"removed": "element"}, "`removed` must be a list"),
        ({"removed": [3]}, "`removed` must be a list of texts"),
        ({"changes": {"element.law.kind": "liang-roger"}}, "Did you mean `liang-rogers`"),
        ({"changes": {"element.lew.kind": "tanaka"}}, "no kind at `element.lew.kind`"),
        ({"changes": {"element.material": "flexinol"}}, "Did you mean"),
        ({"changes": {"element.diameter": "30 mm"}}, "at most 20 mm"),
        ({"changes": {"drive.waveform.kind": "carrier"}}, "For a duty cycle, use the drive"),
        ({"removed": ["mechanism.stiffness"]}, "needs `stiffness`"),
    ],
)
def test_what_is_wrong_is_a_sentence(request_: dict[str, Any], words_: str) -> None:
    with pytest.raises((InputError, UnknownNameError), match=words_):
        answer({"text": TEXT, **request_}, DESK)


def test_an_empty_text_is_a_new_scenario() -> None:
    found = form("")
    assert found["title"] == "Wire and dead weight"
    assert read_scenario(found["text"], FOLDER / "x.toml").run(runtime="floats").status.name == "OK"
