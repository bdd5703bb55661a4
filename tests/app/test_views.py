"""What the charts are told of a run, against the run itself."""

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from one_wire import cool, hang, write_wire

from martensite.app.calls.scenarios import compare_documents, run_scenario
from martensite.app.messages import BadMessageError
from martensite.app.views.diagrams import NO_ELEMENT, PRESCRIBED, describe_energy
from martensite.app.views.traces import list_alarms, list_loops, list_panels
from martensite.app.worker import Desk
from martensite.base.errors import DataError, InputError
from martensite.scenario.scenario import load, read_scenario
from martensite.show.summaries.run import tabulate_key_results
from martensite.simulate.cycle_energies import compute_cycle_energies
from martensite.simulate.energy import find_length
from martensite.simulate.result import Result

EXAMPLES = Path(__file__).parents[2] / "examples"


@cache
def ran(name: str, *changes: tuple[str, Any]) -> Result:
    return load(EXAMPLES / f"{name}.toml", dict(changes) or None).run(runtime="floats")


def power(watt: str) -> Result:
    return ran("constant_power", ("drive.waveform.high", watt))


SHORT_PULSE = write_wire(
    "thin wire, one short pulse in an hour",
    diameter="0.1 mm",
    length="100 mm",
    cooling=cool(150),
    mechanism=hang("100 g"),
    drive='kind = "current"\nwaveform = { kind = "step", high = "1.2 A", at = "30.1 s", until = "30.2 s" }',
    run='duration = "3600 s"',
)


def test_numbers_of_the_bench_are_those_of_the_accepted_steps() -> None:
    """Source of truth: extremes, measures and alarms of the run; its samples are 3.6 s apart and miss the pulse."""
    run = run_scenario({"text": SHORT_PULSE}, Desk(Path()))
    result = read_scenario(SHORT_PULSE, Path("pulse.toml")).run(runtime="floats")
    (alarm,), (told,) = result.alarms, run["alarms"]
    energy, columns = {one["key"]: one["values"] for one in run["energy"]["courses"]}, run["columns"]
    low, high = result.extremes["hottest"]
    key = dict(run["key"])
    for found, wanted in (
        (run["stroke"], result.measure("stroke")),
        (run["ends"]["hottest"], (low, high)),
        (run["ends"]["power"][1], result.measure("max(power)")),
        (max(columns["hottest"]), high),
        (max(columns["position"]) - min(columns["position"]), run["stroke"]),
        (energy["electrical"][-1], result.measure("energy")),
        (energy["lost"][-1], result.measure("integral(heat_loss)")),
        (told["spans"], [(alarm.first, alarm.first + alarm.duration)]),
        (float(key["peak temperature"].split()[0]), high - 273.15),
        (float(key["electrical energy in"].split()[0]), result.measure("energy")),
        (float(key["time beyond limits"].split()[0]), alarm.duration),
    ):
        assert np.asarray(found) == pytest.approx(np.asarray(wanted), rel=5e-4)
    assert high > max(result.columns["hottest"]) + 100.0


def test_every_column_stands_in_one_panel() -> None:
    for name in ("closed_loop_guarded", "closed_loop_platform", "closed_loop_sensorless"):
        result = ran(name)
        found = [c for panel in list_panels(result) for own in panel["ports"].values() for c in own]
        assert len(found) == len(set(found))
        missing = set(result.columns) - set(found)
        assert {c.rpartition(".")[-1] for c in missing} <= {"hottest", "oriented_fraction", "heat_loss"}


def test_what_belongs_together_stands_together() -> None:
    panels = {panel["key"]: panel for panel in list_panels(ran("closed_loop_guarded"))}
    assert panels["position"]["ports"][""] == ["position", "measured.position", "reference"]
    assert panels["drive"]["ports"]["element"] == ["drive", "wanted"]
    assert panels["temperature"]["ports"]["element"] == ["temperature", "measured.heat"]
    assert panels["martensite_fraction"]["includes"] == (0.0, 1.0)
    assert not panels["alarm"]["usual"]


def test_ports_of_several_actuators_stand_apart() -> None:
    result = ran("closed_loop_platform")
    panels = {panel["key"]: panel for panel in list_panels(result)}
    ports = list(result.system.actuators())
    assert list(panels["stress"]["ports"]) == ports
    assert panels["alpha"]["ports"][""][:2] == ["alpha", "beta"]
    assert [loop["key"] for loop in list_loops(result)][-1] == "stress-strain"
    assert list_loops(result)[0]["ports"]["first"] == ["first.temperature", "first.martensite_fraction"]


def test_a_system_without_elements_has_no_loops() -> None:
    result = ran("model_run")
    assert list_loops(result) == []
    assert describe_energy(result)["sentence"] == NO_ELEMENT


def test_the_energies_are_those_of_the_analysis() -> None:
    result = power("0.45 W")
    whole = compute_cycle_energies(result, result.times[-1])
    last = {course["key"]: course["values"][-1] for course in describe_energy(result)["courses"]}
    assert last["electrical"] == pytest.approx(whole.electrical[0], rel=1e-12)
    assert last["lost"] == pytest.approx(whole.lost[0], rel=1e-12)
    assert last["work"] == pytest.approx(whole.work[0], rel=1e-12)
    assert last["returned"] == pytest.approx(whole.returned[0], rel=1e-12)
    assert last["stored"] == pytest.approx(whole.stored_energy[0], abs=1e-12)
    assert describe_energy(result)["efficiency"][-1] == pytest.approx(whole.efficiency[0])


def test_a_wire_on_a_line_works_by_its_own_shortening() -> None:
    """F dx over the position of a bias spring is F dL over the strain of the wire."""
    result = power("0.45 W")
    (actuator,) = result.system.actuators().values()
    length = find_length(actuator.element)
    assert length is not None
    shortening = -length * np.asarray(result["strain"])
    moved = np.asarray(result["position"])
    assert np.ptp(shortening - moved) < 1e-9 * np.ptp(moved)


def test_prescribed_temperatures_have_no_balance() -> None:
    drive = {"kind": "temperature", "waveform": {"kind": "constant", "level": "25 degC"}}
    found = describe_energy(load(EXAMPLES / "constant_power.toml", {"drive": drive}).run())
    assert found["sentence"] == PRESCRIBED
    assert found["courses"] == []


def spans_of(result: Result) -> dict[str, dict[str, Any]]:
    return {alarm["kind"]: alarm for alarm in list_alarms(result)}


def test_spans_add_up_to_the_duration_of_the_alarm() -> None:
    limits = {
        "element.limits.temperature_limit": "90 degC",
        "element.limits.stress_limit": "80 MPa",
        "element.limits.strain_limit": "2 %",
    }
    result = ran("constant_power", *limits.items())
    found = spans_of(result)
    assert set(found) == {"temperature", "stress", "strain"}
    for alarm in found.values():
        assert alarm["spans"][0][0] == pytest.approx(alarm["first"])
        total = sum(end - begin for begin, end in alarm["spans"])
        assert total == pytest.approx(alarm["duration"], rel=1e-9)
    assert found["temperature"]["panel"] == "temperature"
    assert found["temperature"]["level"] == pytest.approx(363.15)
    assert found["strain"]["level"] is None


def test_a_supply_at_its_limit_has_spans() -> None:
    alarm = spans_of(ran("closed_loop_platform"))["supply"]
    assert alarm["port"] == "first"
    assert alarm["column"] == "first.drive"
    total = sum(end - begin for begin, end in alarm["spans"])
    assert total == pytest.approx(alarm["duration"], rel=1e-6)


def test_the_alarm_of_the_supervisor_is_told() -> None:
    alarm = spans_of(ran("closed_loop_guarded"))["supervisor"]
    assert alarm["duration"] == pytest.approx(sum(b - a for a, b in alarm["spans"]))
    assert alarm["first"] == alarm["spans"][0][0] > 0.0


def test_a_run_without_alarms_tells_none() -> None:
    assert list_alarms(power("0.1 W")) == []


def key_results(result: Result) -> dict[str, str]:
    return {row[0]: row[1] for row in tabulate_key_results(result).rows}


def test_key_results_are_those_of_the_run() -> None:
    result = power("0.45 W")
    found = key_results(result)
    name = result.outputs[result.coordinate].long_name
    assert found[f"stroke ({name})"] == f"{1e3 * result.stroke:.4g} mm"
    assert found["peak temperature"] == f"{max(result['hottest']) - 273.15:.4g} °C"
    assert found["time beyond limits"] == "0 s"
    energies = {one["key"]: one["values"][-1] for one in describe_energy(result)["courses"]}
    assert found["electrical energy in"] == f"{energies['electrical']:.4g} J"
    assert found["work during contraction"] == f"{1e3 * energies['work']:.4g} mJ"


def test_more_power_is_hotter() -> None:
    """The same of another run: these rows can tell runs apart."""
    cold, hot = (key_results(power(w)) for w in ("0.45 W", "0.5 W"))
    peaks = [float(one["peak temperature"].split()[0]) for one in (cold, hot)]
    assert peaks[1] > peaks[0]
    assert hot["efficiency (work over electrical)"] != cold["efficiency (work over electrical)"]


def asked(*texts: Any) -> list[dict[str, Any]]:
    return compare_documents({"texts": list(texts)}, Desk(Path()))["rows"]


def test_documents_are_compared_by_path() -> None:
    one = 'title = "a"\n[element]\nkind = "wire"\ndiameter = "0.2 mm"\n'
    other = one.replace("0.2", "0.3") + '[run]\nduration = "1 s"\n'
    assert asked(one, one) == []
    assert asked(one, other) == [
        {"path": "element.diameter", "values": ["0.2 mm", "0.3 mm"]},
        {"path": "run.duration", "values": [None, "1 s"]},
    ]
    assert tomllib.loads(other)["run"]


@pytest.mark.parametrize(
    ("texts", "error"), [(["a = "], DataError), ([1], BadMessageError), (["a = 1"] * 13, BadMessageError)]
)
def test_what_is_no_document_is_refused(texts: list[Any], error: type[InputError]) -> None:
    with pytest.raises(error):
        asked(*texts)


def test_a_motor_on_a_beam_has_its_resonance_and_its_speed_in_rpm() -> None:
    """Source of truth: √(k/M) of the file, and the definition of a revolution per minute."""
    text = (EXAMPLES / "sommerfeld_beam.toml").read_text("utf-8")
    found = run_scenario({"text": text, "changes": {"run.duration": "0.5 s"}}, Desk(Path()))
    rows, last = found["views"]["motor"]["rows"], found["views"]["motor"]["resonance"]
    assert rows[last][0] == "sqrt"
    assert {path: found["parameters"][path] for path in ("mechanism.stiffness", "mechanism.mass")} == {
        "mechanism.stiffness": 541.0,
        "mechanism.mass": pytest.approx(0.1961),
    }
    speed = found["outputs"]["rotor_speed"]
    assert (speed["display_unit"], speed["factor"]) == ("rpm", pytest.approx(60.0 / (2.0 * np.pi)))
    assert run_scenario({"text": SHORT_PULSE}, Desk(Path()))["views"]["motor"]["resonance"] is None
