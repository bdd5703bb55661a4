"""Every kind that a form of the bench offers can be chosen, and the scenario builds."""

from pathlib import Path
from typing import Any

import pytest

from martensite.app.calls.form import NEW, build_form
from martensite.app.documents import FOLDER, list_standalone
from martensite.app.forms import documents
from martensite.app.worker import Desk
from martensite.base.files import toml_document
from martensite.base.toml_text import as_toml
from martensite.physics.materials.base import material_names
from martensite.scenario.catalogue import list_registries
from martensite.scenario.overrides import change_document
from martensite.scenario.scenario import read_scenario

ALL = list_registries()
SCENARIOS = {**list_standalone(), "new": NEW.read_text("utf-8")}
PLACES = {
    "element": ("new", "element.kind"),
    "ends": ("new", "element.ends.kind"),
    "law": ("new", "element.law.kind"),
    "resistance": ("new", "element.resistance.kind"),
    "cooling": ("new", "environment.cooling.kind"),
    "fluid": ("new", "environment.cooling.fluid.kind"),
    "mechanism": ("new", "mechanism.kind"),
    "drive": ("new", "drive.kind"),
    "waveform": ("new", "drive.waveform.kind"),
    "sensor": ("closed_loop_guarded", "sensors.spare.kind"),
    "observer": ("closed_loop_sensorless", "observer.kind"),
    "controller": ("closed_loop", "controller.kind"),
    "supervisor": ("closed_loop_guarded", "supervisor.kind"),
    "check": ("closed_loop_guarded", "supervisor.checks.hot.kind"),
    "fault": ("closed_loop_guarded", "faults.sensor.kind"),
}
"""Registry -> a scenario, and where it has a kind of that registry."""
SPARE = {"kind": "ideal", "of": "position"}
ANGLES = {
    "sensors": {"alpha": {"kind": "tilt", "of": "alpha"}, "spare": {"kind": "ideal", "of": "alpha"}},
    "sensor": None,
}
DIFFERENT: dict[tuple[str, str], tuple[str, dict[str, Any], str]] = {
    ("waveform", "carrier"): ("new", {"drive.kind": "pwm-voltage"}, "a duty drives a switch, not a current"),
    ("controller", "cascade"): (
        "closed_loop",
        {"sensors": {"position": {"kind": "position"}, "temperature": {"kind": "thermocouple"}}, "sensor": None},
        "it reads a temperature as well",
    ),
    ("controller", "constant-power"): ("closed_loop_power", {}, "it reads voltage and current"),
    ("controller", "relay-tuning"): ("closed_loop", {"controller.high": 1.0}, "its relay takes the whole signal"),
    ("sensor", "encoder"): ("closed_loop_platform", ANGLES, "it reads an angle"),
    ("sensor", "gyroscope"): ("closed_loop_platform", ANGLES, "it reads an angle"),
    ("sensor", "tilt"): ("closed_loop_platform", ANGLES, "it reads an angle"),
    ("check", "mismatch"): (
        "closed_loop_guarded",
        {"supervisor.checks.hot": {"kind": "sensor-lost", "reading": "position", "timeout": "1 s"}},
        "it compares readings of one unit",
    ),
}
"""Kinds that make no sense where the others are tried: where they do, and why."""
ALONE = [(r, k) for r in ALL for k in ALL[r].names() if (r, k) != ("controller", "follower")]
"""All kinds but one that makes sense only beside another, which leads it."""


def desk(tmp_path: Path) -> Desk:
    return Desk(tmp_path)


def answer(request: dict[str, Any], at: Desk) -> Any:
    """The form, as the page takes it."""
    return build_form(request, at)


def begun(registry: str, kind: str) -> str:
    """The scenario that a kind is put into."""
    name, changes, _ = DIFFERENT.get((registry, kind), (PLACES[registry][0], {}, ""))
    document = toml_document(SCENARIOS[name])
    if registry == "sensor":
        document.setdefault("sensors", {})["spare"] = SPARE
    if "drive.kind" in changes:
        return answer({"text": as_toml(document), "changes": changes}, Desk(Path()))["text"]
    document = change_document(document, changes)
    return as_toml({key: value for key, value in document.items() if value is not None})


@pytest.mark.parametrize(("registry", "kind"), ALONE, ids=str)
def test_every_kind_can_be_chosen(registry: str, kind: str, tmp_path: Path) -> None:
    _, path = PLACES[registry]
    found = answer({"text": begun(registry, kind), "changes": {path: kind}}, desk(tmp_path))
    assert found["missing"] == [], found["refused"]
    document = toml_document(found["text"])
    place = documents.find_table(document, path.removesuffix(".kind"))
    assert place.get("kind", kind) == kind
    read_scenario(found["text"], FOLDER / "scenario.toml")
    for assumed in found["assumed"]:
        assert documents.find_entry(document, assumed) is not None, assumed


@pytest.mark.parametrize("name", material_names())
@pytest.mark.parametrize("scenario", ["new", "platform_spring", "clamped_wire", "finger"])
def test_every_material_can_be_chosen(name: str, scenario: str, tmp_path: Path) -> None:
    request = {"text": SCENARIOS[scenario], "changes": {"element.material": name}}
    found = answer(request, desk(tmp_path))
    assert found["missing"] == []
    assert toml_document(found["text"])["element"]["material"] == name
    read_scenario(found["text"], FOLDER / "scenario.toml")


def test_every_registry_has_a_place() -> None:
    assert set(PLACES) == set(ALL)


def test_packaged_scenarios_to_begin_with_are_there() -> None:
    kinds = [ALL["mechanism"][kind] for kind in ALL["mechanism"].names()]
    assert {kind.typical_scenario or "new" for kind in kinds} <= set(SCENARIOS)


@pytest.mark.parametrize("kind", ALL)
def test_the_typical_one_of_a_registry_is_there(kind: str) -> None:
    typical = ALL[kind].typical
    assert not typical or ALL[kind][typical].registered_name == typical
